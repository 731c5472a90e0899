#include "core/json.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/dataset.h"
#include "core/error.h"
#include "core/files.h"

namespace wheatstone {
namespace {

namespace fs = std::filesystem;

class JsonFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        fs::path(testing::TempDir()) /
        (std::string("json_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
    make_folder(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string error_of(const std::string& text) {
    write_text_atomically(folder_ / "dataset.json", text);
    try {
      Dataset(folder_).read_manifest();
    } catch (const FileError& e) {
      return e.what();
    }
    return "";
  }
  fs::path folder_;
};

TEST_F(JsonFiles, ManifestRoundTrips) {
  const DatasetManifest m{"capture", "card", 18446744073709551615ULL, 0.1, "here", 0, 1};
  Dataset(folder_).write_manifest(m);
  const DatasetManifest back = Dataset(folder_).read_manifest();
  EXPECT_EQ(back.kind, m.kind);
  EXPECT_EQ(back.seed, m.seed);
  EXPECT_EQ(back.scale, m.scale);
}

TEST_F(JsonFiles, ErrorsNameFileCauseAndRemedy) {
  EXPECT_NE(error_of("{").find("not valid JSON"), std::string::npos);
  EXPECT_NE(error_of("{}").find("has no \"schema\""), std::string::npos);
  EXPECT_NE(error_of(R"({"schema":"wheatstone-dataset/2"})").find("wheatstone-dataset/2"),
            std::string::npos);
  EXPECT_NE(error_of(R"({"schema":"wheatstone-dataset/1"})").find("\"kind\" is missing"),
            std::string::npos);
  EXPECT_NE(error_of(R"({"schema":"wheatstone-dataset/1","kind":3})").find("wrong type"),
            std::string::npos);
  EXPECT_THROW(Dataset(folder_ / "nowhere").read_manifest(), FileError);
}

TEST_F(JsonFiles, NumbersThatAreNotFiniteAreNeverWritten) {
  EXPECT_THROW(write_json(folder_ / "x.json", "s/1", {{"v", {1.0, std::nan("")}}}), InternalError);
  EXPECT_FALSE(fs::exists(folder_ / "x.json"));
}

}  // namespace
}  // namespace wheatstone
