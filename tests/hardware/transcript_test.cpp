#include "hardware/transport/transcript.h"

#include <gmock/gmock.h>

#include <fstream>

#include "core/error.h"
#include "core/files.h"
#include "core/random.h"
#include "tests/error_text.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

using ::testing::HasSubstr;

TEST(Transcript, ReadsBackWhatItWrote) {
  const TemporaryFolder folder;
  std::string all;
  for (int i = 0; i < 256; ++i) all += static_cast<char>(i);
  {
    Transcript transcript(folder.path / "t.jsonl");
    transcript.to_device(all);
    transcript.to_host("");
    transcript.to_host("ok\r\n");
  }
  const auto entries = read_transcript(folder.path / "t.jsonl");
  ASSERT_EQ(entries.size(), 3U);
  EXPECT_TRUE(entries[0].to_device);
  EXPECT_EQ(entries[0].bytes, all);
  EXPECT_EQ(entries[2].bytes, "ok\r\n");
  EXPECT_LE(entries[0].ns, entries[2].ns);
  EXPECT_EQ(hex_of("A\xff"), "41 ff");
  EXPECT_EQ(hex_of("ABC", 2), "41 42 ...");
}

TEST(Transcript, RefusesOtherLinesByNumber) {
  const TemporaryFolder folder;
  const auto file = folder.path / "t.jsonl";
  const std::string good = R"({"ns": 1, "to": "host", "hex": "00ff"})"
                           "\n";
  for (const char* bad :
       {"x", "{}", R"({"ns": 1, "to": "me", "hex": ""})", R"({"ns": 1, "to": "host", "hex": "0"})",
        R"({"ns": 1, "to": "host", "hex": "zz"})", "[]"}) {
    write_text_atomically(file, good + bad + "\n");
    EXPECT_THAT(error_of([&] { read_transcript(file); }), HasSubstr("line 2")) << bad;
  }
}

TEST(Transcript, SurvivesAnyBytes) {
  const TemporaryFolder folder;
  const auto file = folder.path / "t.jsonl";
  const std::string good = R"({"ns": 1, "to": "host", "hex": "00ff"})";
  RandomStream random(4, 0);
  for (int i = 0; i < 20'000; ++i) {
    std::string text = good + "\n" + good;
    for (int n = 0; n < 2; ++n)
      text[static_cast<std::size_t>(random.uniform() * static_cast<double>(text.size()))] =
          static_cast<char>(random.next());
    std::ofstream(file, std::ios::binary) << text;
    try {
      read_transcript(file);
    } catch (const FileError&) {
    }
  }
}

}  // namespace
}  // namespace wheatstone
