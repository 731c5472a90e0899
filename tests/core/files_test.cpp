#include "core/files.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "core/error.h"

namespace wheatstone {
namespace {

namespace fs = std::filesystem;

class AtomicFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        fs::path(testing::TempDir()) /
        (std::string("files_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
    make_folder(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  int entries() const {
    int n = 0;
    for ([[maybe_unused]] const auto& e : fs::directory_iterator(folder_)) ++n;
    return n;
  }
  fs::path folder_;
};

TEST_F(AtomicFiles, WritesWhatItWasGiven) {
  write_text_atomically(folder_ / "a.txt", "one");
  write_text_atomically(folder_ / "a.txt", "two");
  EXPECT_EQ(read_text(folder_ / "a.txt"), "two");
  EXPECT_EQ(entries(), 1);
}

TEST_F(AtomicFiles, AFailureLeavesTheOldFileAndNothingElse) {
  write_text_atomically(folder_ / "a.txt", "old");
  EXPECT_THROW(write_atomically(folder_ / "a.txt",
                                [](const fs::path& temporary) {
                                  std::ofstream(temporary) << "half";
                                  throw InternalError("boom");
                                }),
               InternalError);
  EXPECT_EQ(read_text(folder_ / "a.txt"), "old");
  EXPECT_EQ(entries(), 1);
}

TEST_F(AtomicFiles, NoSpaceIsSaidAndNothingIsLeft) {
  // /dev/full answers every write with ENOSPC, as a full disk does.
  EXPECT_THROW(
      {
        try {
          write_atomically(folder_ / "a.bin", [](const fs::path& temporary) {
            fs::create_symlink("/dev/full", temporary);
            std::ofstream out(temporary);
            out << "x";
            out.close();
            if (!out) throw FileError(temporary, "no space left", "free space");
          });
        } catch (const FileError& e) {
          EXPECT_NE(std::string(e.what()).find("space"), std::string::npos);
          throw;
        }
      },
      FileError);
  EXPECT_FALSE(fs::exists(folder_ / "a.bin"));
}

TEST_F(AtomicFiles, MissingFolderIsNamed) {
  try {
    write_text_atomically(folder_ / "no" / "a.txt", "x");
    FAIL();
  } catch (const FileError& e) {
    EXPECT_NE(std::string(e.what()).find("there is no folder"), std::string::npos);
  }
}

TEST_F(AtomicFiles, AFolderInPlaceOfAFileIsRefused) {
  make_folder(folder_ / "a.txt");
  EXPECT_THROW(write_text_atomically(folder_ / "a.txt", "x"), FileError);
  EXPECT_THROW(read_bytes(folder_ / "a.txt"), FileError);
  write_text_atomically(folder_ / "file", "x");
  EXPECT_THROW(make_folder(folder_ / "file" / "below"), FileError);
}

TEST_F(AtomicFiles, LeftoversOfTheDeadGoAndThoseOfTheLivingStay) {
  const pid_t dead = ::fork();
  if (dead == 0) ::_exit(0);
  ::waitpid(dead, nullptr, 0);
  const fs::path left = folder_ / (".a." + std::to_string(dead) + ".0.part.png"),
                 living = folder_ / (".a." + std::to_string(::getpid()) + ".1.part"),
                 other = folder_ / ".part.png", data = folder_ / "a.png";
  for (const fs::path& path : {left, living, other, data}) write_text_atomically(path, "x");
  remove_unfinished(folder_);
  EXPECT_FALSE(fs::exists(left));
  for (const fs::path& path : {living, other, data}) EXPECT_TRUE(fs::exists(path)) << path;
  remove_unfinished(folder_ / "nowhere");
}

TEST_F(AtomicFiles, TooLargeAFileIsRefusedBeforeItIsRead) {
  write_text_atomically(folder_ / "a.txt", "12345");
  EXPECT_THROW(read_bytes(folder_ / "a.txt", 4), FileError);
}

}  // namespace
}  // namespace wheatstone
