// Damaged models: every outcome is a model or a wheatstone::Error.

#include <gtest/gtest.h>

#include "capture/import/colmap.h"
#include "core/error.h"
#include "core/files.h"
#include "core/random.h"
#include "tests/shared_data.h"

namespace wheatstone {
namespace {

struct Outcomes {
  int models = 0, errors = 0;
};

Outcomes fuzz(const ColmapSource& good, int iterations, std::uint64_t seed) {
  Outcomes outcomes;
  for (int i = 0; i < iterations; ++i) {
    RandomStream random(seed, static_cast<std::uint64_t>(i));
    ColmapSource s = good;
    std::string* const files[] = {&s.cameras, &s.images, &s.points};
    std::string& file = *files[random.next() % 3];
    const int flips = static_cast<int>(random.next() % 4);
    // Half of the flips go to the beginning, where the counts and the sizes are.
    for (int k = 0; k < flips; ++k) {
      const std::size_t range =
          random.next() % 2 ? file.size() : std::min<std::size_t>(200, file.size());
      file[random.next() % range] ^= static_cast<char>(1u << (random.next() % 8));
    }
    if (flips == 0 || random.next() % 4 == 0) file.resize(random.next() % file.size());
    try {
      const ColmapModel m = parse_colmap(s, "pictures");
      ++outcomes.models;
      if (!m.observations.empty()) median_reprojection_error_px(m);
    } catch (const Error&) {
      ++outcomes.errors;
    }
  }
  return outcomes;
}

TEST(ColmapFuzz, SmallTextModels) {
  const ColmapSource good{
      "model", false, "1 OPENCV 640 480 500 510 320 240 0.1 -0.02 0.001 0.002\n",
      "1 1 0 0 0 1 2 3 1 a.jpg\n320.5 240.5 7 1 2 -1\n2 1 0 0 0 0 0 0 1 c.jpg\n\n",
      "7 -1 -2 7 10 20 30 0.5 1 0\n8 1 2 9 10 20 30 0.5 1 0\n"};
  const Outcomes o = fuzz(good, 2000, 1);
  EXPECT_GT(o.errors, 200);
  EXPECT_GT(o.models, 50);
}

TEST(ColmapFuzz, SmallBinaryModel) {
  const auto put = [](std::string& to, auto... values) {
    (to.append(reinterpret_cast<const char*>(&values), sizeof(values)), ...);
  };
  ColmapSource good{"model", true, {}, {}, {}};
  put(good.cameras, std::uint64_t{1}, 1, 2, std::uint64_t{640}, std::uint64_t{480}, 500.0, 320.0,
      240.0, 0.1);
  put(good.images, std::uint64_t{1}, 1, 1.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 1, 'a', '\0',
      std::uint64_t{1}, 320.5, 240.5, std::uint64_t{7});
  put(good.points, std::uint64_t{1}, std::uint64_t{7}, -1.0, -2.0, 7.0, 'r', 'g', 'b', 0.5,
      std::uint64_t{1}, 1, 0);
  ASSERT_EQ(parse_colmap(good, "pictures").observations.size(), 1u);
  const Outcomes o = fuzz(good, 2000, 2);
  EXPECT_GT(o.errors, 200);
  EXPECT_GT(o.models, 50);
}

TEST(ColmapFuzz, VestaBinary) {
  const auto folder = shared_folder("data/captured_poses/vesta");
  REQUIRE_SHARED(folder);
  const ColmapSource good{folder, true, read_text(folder / "cameras.bin"),
                          read_text(folder / "images.bin"), read_text(folder / "points3D.bin")};
  const Outcomes o = fuzz(good, 2000, 3);
  EXPECT_GT(o.errors, 200);
  EXPECT_GT(o.models, 50);
}

}  // namespace
}  // namespace wheatstone
