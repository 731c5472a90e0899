// A photograph that was left out of a real light field, rendered from the others.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "apps/import.h"
#include "apps/stations.h"
#include "program.h"

namespace wheatstone::apps {
namespace {

namespace fs = std::filesystem;
using LeftOut = TemporaryFolder;

fs::path shared_data() {
  const char* folder = std::getenv("WHEATSTONE_SHARED");
  return fs::path(folder != nullptr ? folder : WHEATSTONE_DEFAULT_SHARED) / "data";
}

// Eight hand-held photographs along a wall: neighbours share little more than half of a picture, so
// the focal plane has to be found in a wide range of depths. The first stands at the row's end.
TEST_F(LeftOut, SparseHandHeldPhotographs) {
  const fs::path input = shared_data() / "captured_poses" / "lund_door";
  if (!fs::exists(input)) {
    const char* ci = std::getenv("CI");
    if (ci != nullptr && std::string(ci) == "true") FAIL() << input << " is missing";
    GTEST_SKIP() << input << " is missing; set WHEATSTONE_SHARED";
  }
  const Dataset dataset(root_ / "door");
  import_input(input, dataset, {});
  for (const char* view : {"DSC_0001", "DSC_0005"}) {
    const LeftOutReport r = render_left_out(dataset, view, std::nullopt, false);
    EXPECT_GT(r.psnr_drlf_db, 2 + std::max(r.psnr_nearest_db, r.psnr_average_db)) << view;
  }
}

}  // namespace
}  // namespace wheatstone::apps
