#include "capture/import/colmap.h"

#include <gmock/gmock.h>

#include "core/error.h"
#include "tests/shared_data.h"

namespace wheatstone {
namespace {

ColmapSource small_text() {
  return {"model", false,
          "# cameras\n1 OPENCV 640 480 500 510 320 240 0.1 -0.02 0.001 0.002\n"
          "2 PINHOLE 640 480 500 510 320 240\n3 RADIAL 640 480 500 320 240 0.1 -0.02\n"
          "4 SIMPLE_PINHOLE 640 480 500 320 240\n5 SIMPLE_RADIAL 640 480 500 320 240 0.1\n",
          "# images\n1 1 0 0 0 1 2 3 1 a b.jpg\n320.5 240.5 7 1 2 -1\n2 1 0 0 0 0 0 0 3 c.jpg\n\n",
          "# points\n7 -1 -2 7 10 20 30 0.5 1 0\n"};
}

std::string failure(const ColmapSource& s) {
  try {
    parse_colmap(s, "pictures");
  } catch (const FileError& e) {
    return e.what();
  }
  return "no FileError";
}

TEST(Colmap, ConvertsPixelCentresUnitsAndModels) {
  const ColmapModel m = parse_colmap(small_text(), "pictures", 10);
  ASSERT_EQ(m.views.size(), 2u);
  EXPECT_EQ(m.views[0].name, "a b.jpg");
  EXPECT_THAT(m.missing_files, testing::ElementsAre("a b.jpg", "c.jpg"));
  EXPECT_TRUE(m.views[0].path.empty());
  EXPECT_EQ(m.views[0].intrinsics.fy_px, 510);
  EXPECT_EQ(m.views[0].intrinsics.cx_px, 319.5);
  EXPECT_EQ(m.views[0].intrinsics.cy_px, 239.5);
  EXPECT_EQ(m.views[0].distortion.p2, 0.002);
  EXPECT_EQ(m.views[1].intrinsics.fy_px, 500);
  EXPECT_EQ(m.views[1].distortion.k2, -0.02);
  EXPECT_EQ(m.views[0].T_camera_world.t_mm, Eigen::Vector3d(10, 20, 30));
  ASSERT_EQ(m.observations.size(), 1u);  // the untracked one is left out
  EXPECT_EQ(m.observations[0].pixel, Eigen::Vector2d(320, 240));
  EXPECT_EQ(m.points[0].p_world_mm, Eigen::Vector3d(-10, -20, 70));
  EXPECT_NEAR(median_reprojection_error_px(m), std::sqrt(0.5),
              1e-9);  // on the axis: (319.5, 239.5)
}

TEST(Colmap, ErrorsNameTheLine) {
  using testing::HasSubstr;
  ColmapSource s = small_text();
  s.cameras = "# c\n1 FISHEYE 640 480 500 320 240\n";
  EXPECT_THAT(failure(s), HasSubstr("cameras.txt: line 2 has the unread camera model FISHEYE"));
  s = small_text();
  s.images = "1 1 0 0 0 1 2 3 9 a.jpg\n\n";
  EXPECT_THAT(failure(s), HasSubstr("images.txt: line 1 has a camera number"));
  s.images = "1 1 0 0 0 1 2 3 1 ../a.jpg\n\n";
  EXPECT_THAT(failure(s), HasSubstr("leaves the picture folder"));
  s.images = "1 1 0 0 0 1 2 3 1 a.jpg\n1 2 8\n";
  EXPECT_THAT(failure(s), HasSubstr("points3D lacks"));
  s.images = "1 0 0 0 0 1 2 3 1 a.jpg\n\n";
  EXPECT_THAT(failure(s), HasSubstr("quaternion"));
  s = small_text();
  s.points = "7 -1 x 7 10 20 30 0.5\n";
  EXPECT_THAT(failure(s), HasSubstr("points3D.txt: line 1 has a bad point coordinate"));
  EXPECT_THROW(parse_colmap(small_text(), "p", 0), ArgumentError);
  EXPECT_THROW(read_colmap("/nonexistent", "p"), FileError);
}

TEST(Colmap, HostileCountsAreRefusedBeforeMemoryIsTaken) {
  ColmapSource s{"model", true, std::string(8, '\xff'), std::string(8, '\0'), std::string(8, '\0')};
  EXPECT_THAT(failure(s), testing::HasSubstr("more than the file can hold"));
  s.cameras = std::string(8, '\0');
  EXPECT_EQ(parse_colmap(s, "p").views.size(), 0u);
  s.points = std::string(7, '\x7f');
  EXPECT_THAT(failure(s), testing::HasSubstr("the file's end"));
}

TEST(Colmap, LundDoorReprojects) {
  const auto folder = shared_folder("data/captured_poses/lund_door");
  REQUIRE_SHARED(folder);
  const ColmapModel m = read_colmap(folder / "colmap", folder / "images");
  ASSERT_EQ(m.views.size(), 12u);
  EXPECT_EQ(m.points.size(), 11384u);
  EXPECT_THAT(m.missing_files, testing::UnorderedElementsAre("DSC_0003.JPG", "DSC_0006.JPG",
                                                             "DSC_0009.JPG", "DSC_0012.JPG"));
  for (std::size_t i = 0; i < m.views.size(); ++i) {
    const double e = median_reprojection_error_px(m, i);
    EXPECT_GT(e, 0.20) << m.views[i].name;
    EXPECT_LT(e, 0.26) << m.views[i].name;
    const Eigen::Vector3d c = camera_centre(m.views[i].T_camera_world);
    EXPECT_LT(std::abs(c.y()), 0.22);
    if (m.views[i].name == "DSC_0001.JPG") {
      EXPECT_NEAR(c.x(), 8.1, 0.1);
    }
    if (m.views[i].name == "DSC_0012.JPG") {
      EXPECT_NEAR(c.x(), -5.3, 0.1);
    }
  }
  RecordProperty("median_px", std::to_string(median_reprojection_error_px(m)));
  const LightFieldView view = load_view(m.views[0], 100);
  EXPECT_EQ(view.light_cd_m2.width(), 1296);
  EXPECT_EQ(view.light_cd_m2.height(), 1936);
  EXPECT_THROW(load_view(m.views[2], 100), FileError);  // held out
}

TEST(Colmap, VestaBinary) {
  const auto folder = shared_folder("data/captured_poses/vesta");
  REQUIRE_SHARED(folder);
  const ColmapModel m = read_colmap(folder, folder / "images");
  ASSERT_EQ(m.views.size(), 4u);
  EXPECT_THAT(m.missing_files, testing::ElementsAre("00000002.png"));
  EXPECT_NEAR(m.views[0].intrinsics.fx_px, 10715, 1);
  EXPECT_NEAR(m.views[0].intrinsics.cx_px, 511.0009 - 0.5, 1e-4);  // as stored: 511.0009
  EXPECT_LT(median_reprojection_error_px(m), 1.0);
}

}  // namespace
}  // namespace wheatstone
