// A photograph that was left out of a real light field, rendered from the others.
#include <gtest/gtest.h>

#include <algorithm>

#include "apps/import.h"
#include "apps/stations.h"
#include "program.h"
#include "tests/shared_data.h"

namespace wheatstone::apps {
namespace {

namespace fs = std::filesystem;
using LeftOut = TemporaryFolder;

// Eight hand-held photographs along a wall: neighbours share little more than half of a picture, so
// the focal plane has to be found in a wide range of depths. The first stands at the row's end.
TEST_F(LeftOut, SparseHandHeldPhotographs) {
  const fs::path input = shared_folder("data/captured_poses/lund_door");
  REQUIRE_SHARED(input);
  const Dataset dataset(root_ / "door");
  import_input(input, dataset, {});
  for (const char* view : {"DSC_0001", "DSC_0005"}) {
    const LeftOutReport r = render_left_out(dataset, view, std::nullopt, false);
    EXPECT_GT(r.psnr_drlf_db, 2 + std::max(r.psnr_nearest_db, r.psnr_average_db)) << view;
  }
}

}  // namespace
}  // namespace wheatstone::apps
