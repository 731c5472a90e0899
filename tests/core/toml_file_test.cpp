#include "core/toml_file.h"

#include <gmock/gmock.h>

#include <fstream>
#include <functional>

#include "core/error.h"
#include "core/files.h"
#include "core/random.h"
#include "tests/error_text.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class TomlFileTest : public ::testing::Test {
 protected:
  TomlTable read(const std::string& text) {
    write_text_atomically(file_, text);
    return TomlTable::read(file_, "docs/x.md");
  }
  std::string refusal(const std::string& text, const std::function<void(const TomlTable&)>& use) {
    return error_of([&] { use(read(text)); });
  }

  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.path / "x.toml";
};

TEST_F(TomlFileTest, ReadsWhatIsThere) {
  const TomlTable t = read(
      "name = \"a\"\nlength_mm = 3\nn = 4\non = true\nk = [1, 2.5]\np = [[1, 2, 3]]\n[a]\nb = 1.5\n"
      "[[c]]\nd = 1\n[[c]]\nd = 2\n");
  EXPECT_EQ(t.text("name"), "a");
  EXPECT_EQ(t.text_or("nothing", "x"), "x");
  EXPECT_EQ(t.number("length_mm", 0, 10), 3);
  EXPECT_EQ(t.integer("n", 0, 10), 4);
  EXPECT_TRUE(t.flag_or("on", false));
  EXPECT_EQ((t.numbers<2>("k", 0, 10)), (std::array{1.0, 2.5}));
  EXPECT_EQ(t.points("p").at(0), (std::array{1.0, 2.0, 3.0}));
  EXPECT_EQ(t.table("a").number("b", 0, 2), 1.5);
  EXPECT_EQ(t.tables("c").at(1).integer("d", 0, 9), 2);
  t.finish();
}

TEST_F(TomlFileTest, NamesFileLineAndKey) {
  EXPECT_THAT(refusal("a = 1\nb = \"x\"\n", [](const TomlTable& t) { t.number("b", 0, 1); }),
              AllOf(HasSubstr(file_.string()), HasSubstr("line 2"), HasSubstr("\"b\""),
                    HasSubstr("docs/x.md")));
  EXPECT_THAT(refusal("[s]\nb = 3\n", [](const TomlTable& t) { t.table("s").number("b", 0, 1); }),
              AllOf(HasSubstr("line 2"), HasSubstr("\"s.b\""), HasSubstr("from 0 to 1")));
  EXPECT_THAT(refusal("a = \n", [](const TomlTable&) {}), HasSubstr("line 1"));
}

TEST_F(TomlFileTest, RefusesUnknownKeysAndNamesTheOneMeant) {
  const auto use = [](const TomlTable& t) {
    t.number("travel_mm", 0, 1000);
    t.finish();
  };
  EXPECT_THAT(refusal("travel_mm = 1\nspeeed = 2\n", use),
              AllOf(HasSubstr("line 2"), HasSubstr("\"speeed\" is not a key")));
  EXPECT_THAT(refusal("travel_cm = 16.7\n", use),
              AllOf(HasSubstr("\"travel_cm\" is not a key"), HasSubstr("use \"travel_mm\"")))
      << "a wrong unit";
  EXPECT_THAT(refusal("", use), HasSubstr("\"travel_mm\" is missing"));
}

TEST_F(TomlFileTest, RefusesOtherKinds) {
  const std::vector<std::pair<std::string, std::function<void(const TomlTable&)>>> cases = {
      {"a = 1", [](const TomlTable& t) { t.text("a"); }},
      {"a = \"\"", [](const TomlTable& t) { t.text("a"); }},
      {"a = true", [](const TomlTable& t) { t.number("a", 0, 9); }},
      {"a = nan", [](const TomlTable& t) { t.number("a", 0, 9); }},
      {"a = inf", [](const TomlTable& t) { t.number("a", 0, 9); }},
      {"a = 1.5", [](const TomlTable& t) { t.integer("a", 0, 9); }},
      {"a = 10", [](const TomlTable& t) { t.integer("a", 0, 9); }},
      {"a = 1", [](const TomlTable& t) { t.flag_or("a", true); }},
      {"a = [1]", [](const TomlTable& t) { t.numbers<2>("a", 0, 9); }},
      {"a = [1, 99]", [](const TomlTable& t) { t.numbers<2>("a", 0, 9); }},
      {"a = [[1, 2]]", [](const TomlTable& t) { t.points("a"); }},
      {"a = [[1, 2, nan]]", [](const TomlTable& t) { t.points("a"); }},
      {"a = 1", [](const TomlTable& t) { t.table("a"); }},
      {"a = [1]", [](const TomlTable& t) { t.tables("a"); }},
      {"a = \"nowhere.json\"", [](const TomlTable& t) { t.file("a"); }}};
  for (const auto& [text, use] : cases) EXPECT_THAT(refusal(text, use), HasSubstr("\"a\"")) << text;
}

TEST_F(TomlFileTest, SurvivesAnyBytes) {
  const std::string good = "name = \"a\"\n[s]\nk = [[1, 2, 3], [4.5, 5, 6]]\n[[c]]\nd = 0x1F\n";
  RandomStream random(5, 0);
  for (int i = 0; i < 5000; ++i) {
    std::string text = good;
    for (int n = 0; n < 3; ++n)
      text[static_cast<std::size_t>(random.uniform() * static_cast<double>(text.size()))] =
          static_cast<char>(random.next());
    std::ofstream(file_, std::ios::binary) << text;
    try {
      const TomlTable t = TomlTable::read(file_, "docs/x.md");
      t.text_or("name", "");
      if (t.has("s")) t.table("s").points("k");
      t.tables("c");
      t.finish();
    } catch (const FileError&) {
    }
  }
}

}  // namespace
}  // namespace wheatstone
