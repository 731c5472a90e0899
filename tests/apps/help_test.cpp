// What --help promises: every subcommand has an example, of options that it has and of shared files
// that are there.
#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <regex>
#include <sstream>

#include "program.h"
#include "tests/shared_data.h"

namespace wheatstone::apps {
namespace {

using ::testing::HasSubstr;

const std::string& help_of(const std::vector<std::string>& command) {
  static std::map<std::vector<std::string>, std::string> known;
  const auto [help, is_new] = known.try_emplace(command);
  if (is_new) {
    std::vector<std::string> arguments = command;
    arguments.emplace_back("--help");
    const Outcome outcome = run_program(arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    help->second = outcome.out;
  }
  return help->second;
}

std::vector<std::string> words_in(const std::string& text) {
  std::istringstream in(text);
  return {std::istream_iterator<std::string>(in), {}};
}

/// The subcommands that a help lists.
std::vector<std::string> subcommands_in(const std::string& help) {
  std::vector<std::string> names;
  std::istringstream in(help.substr(std::min(help.find("\nSubcommands:\n"), help.size())));
  for (std::string line; std::getline(in, line);)
    if (std::smatch m; std::regex_match(line, m, std::regex("  ([a-z0-9-]+)  .*")))
      names.push_back(m[1]);
  return names;
}

/// Every command with those below it.
std::vector<std::vector<std::string>> all_commands(const std::vector<std::string>& above = {}) {
  std::vector<std::vector<std::string>> commands = {above};
  for (const std::string& name : subcommands_in(help_of(above))) {
    std::vector<std::string> command = above;
    command.push_back(name);
    for (auto& c : all_commands(command)) commands.push_back(std::move(c));
  }
  return commands;
}

TEST(Help, EveryExampleIsOfOptionsThatAreThere) {
  const auto commands = all_commands();
  EXPECT_GT(commands.size(), 35u);
  for (const std::vector<std::string>& command : commands) {
    const std::string& help = help_of(command);
    const auto at = help.find("Example");
    ASSERT_NE(at, std::string::npos) << help;
    std::istringstream lines(help.substr(at));
    int examples = 0;
    for (std::string line; std::getline(lines, line);) {
      const auto program = line.find("wheatstone ");
      if (program == std::string::npos) continue;
      ++examples;
      std::vector<std::string> words = words_in(line.substr(program));
      // The example of a command with subcommands may be one of these.
      std::vector<std::string> shown;
      for (std::size_t i = 1; i < words.size(); ++i) {
        const auto known = subcommands_in(help_of(shown));
        if (std::find(known.begin(), known.end(), words[i]) == known.end()) break;
        shown.push_back(words[i]);
      }
      ASSERT_GE(shown.size(), command.size()) << line;
      EXPECT_TRUE(std::equal(command.begin(), command.end(), shown.begin())) << line;
      const std::string& options = help_of(shown);
      for (const std::string& word : words)
        if (word.starts_with("--")) {
          EXPECT_THAT(options, HasSubstr("  " + word + " ")) << line;
        }
    }
    EXPECT_GT(examples, 0) << help;
  }
}

TEST(Help, AWordThatIsNoSubcommandIsNamed) {
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"capure"}, {"calibrate", "capure", "--images", "x"}}) {
    const Outcome outcome = run_program(command);
    EXPECT_NE(outcome.status, 0);
    EXPECT_THAT(outcome.err, HasSubstr("'capure' is no subcommand"));
  }
  const Outcome none = run_program({});
  EXPECT_NE(none.status, 0);
  EXPECT_THAT(none.err, HasSubstr("subcommand is required"));
}

TEST(Help, SharedFilesOfExamplesAreThere) {
  REQUIRE_SHARED(shared_folder("data"));
  for (const std::vector<std::string>& command : all_commands())
    for (const std::string& word : words_in(help_of(command)))
      if (const std::string shared = "../shared/"; word.starts_with(shared)) {
        EXPECT_TRUE(std::filesystem::exists(shared_folder(word.substr(shared.size())))) << word;
      }
}

}  // namespace
}  // namespace wheatstone::apps
