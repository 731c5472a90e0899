#include "core/journal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>

#include "core/digest.h"
#include "core/error.h"
#include "core/files.h"
#include "tests/error_text.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class JournalTest : public ::testing::Test {
 protected:
  void write(const std::string& text) const { std::ofstream(file_) << text; }

  const TemporaryFolder folder_;
  const fs::path file_ = folder_.path / "journal.jsonl";
};

TEST_F(JournalTest, KeepsWhatWasAppendedInOrder) {
  {
    Journal journal(file_);
    EXPECT_TRUE(journal.records().empty());
    journal.append({{"n", 1}, {"text", "a \"quoted\"\nline"}});
    journal.append({{"n", 2}});
  }
  Journal journal(file_);
  journal.append({{"n", 3}});
  ASSERT_EQ(journal.records().size(), 3U);
  EXPECT_EQ(journal.records()[0].at("text"), "a \"quoted\"\nline");
  EXPECT_EQ(Journal::read(file_), journal.records());
}

TEST_F(JournalTest, CutsOffOnlyALineThatWasNeverFinished) {
  write("{\"n\":1}\n{\"n\":2}\n");
  const std::string whole = read_text(file_);
  for (std::size_t length = 0; length <= whole.size(); ++length) {
    write(whole.substr(0, length));
    const std::size_t lines = length < 8 ? 0 : length < 16 ? 1 : 2;
    EXPECT_EQ(Journal::read(file_).size(), lines) << length;
    EXPECT_EQ(fs::file_size(file_), length) << "reading changes nothing";
    EXPECT_EQ(Journal(file_).records().size(), lines) << length;
    EXPECT_EQ(read_text(file_), whole.substr(0, 8 * lines)) << length;
  }
}

TEST_F(JournalTest, RefusesDamageAndNamesTheLine) {
  for (const char* second : {"{\"n\":2", "", "3", "[1]", "{\"n\":2}}", "\x80\xff"}) {
    write("{\"n\":1}\n" + std::string(second) + "\n{\"n\":3}\n");
    const std::string before = read_text(file_);
    const std::string error = error_of([&] { Journal journal(file_); });
    EXPECT_THAT(error, HasSubstr("line 2 is damaged")) << second;
    EXPECT_THAT(error, HasSubstr(file_.string()));
    EXPECT_EQ(read_text(file_), before) << "nothing is changed";
    EXPECT_THROW(Journal::read(file_), FileError);
  }
}

TEST_F(JournalTest, HasOneWriterAtATime) {
  const Journal journal(file_);
  EXPECT_THAT(error_of([&] { Journal second(file_); }), HasSubstr("in use"));
}

TEST_F(JournalTest, RefusesWhereThereIsNoFolder) {
  const fs::path nowhere = folder_.path / "nowhere" / "journal.jsonl";
  EXPECT_THAT(error_of([&] { Journal journal(nowhere); }), HasSubstr(nowhere.string()));
}

TEST_F(JournalTest, OnAFullDiskTheFileStaysAsItWas) {
  Journal journal(file_);
  journal.append({{"n", 1}});
  const auto size = fs::file_size(file_);
  // The limit stands in for the disk; ignored, its signal becomes an error of write().
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit full{size + 10, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &full), 0);
  const std::string error = error_of([&] { journal.append({{"text", std::string(100, 'x')}}); });
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_THAT(error, HasSubstr(file_.string()));
  EXPECT_THAT(error, HasSubstr("free space"));
  EXPECT_EQ(fs::file_size(file_), size);
  EXPECT_EQ(journal.records().size(), 1U);
  journal.append({{"n", 2}});
  EXPECT_EQ(Journal::read(file_).size(), 2U);
}

TEST(Digest, IsThatOfTheStandard) {
  const auto of = [](const std::string& text) {
    return sha256_hex(std::as_bytes(std::span(text.data(), text.size())));
  };
  EXPECT_EQ(of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(of(std::string(1000000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  const fs::path file = temporary_file("abc");
  std::ofstream(file) << "abc";
  EXPECT_EQ(sha256_hex_of(file), of("abc"));
  EXPECT_THROW(sha256_hex_of(temporary_file("missing")), FileError);
}

}  // namespace
}  // namespace wheatstone
