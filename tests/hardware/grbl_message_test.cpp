#include "hardware/serial/grbl_message.h"

#include <gtest/gtest.h>

#include "core/random.h"

namespace wheatstone {
namespace {

using Type = GrblMessage::Type;

TEST(GrblMessage, KnowsWhatAControllerSays) {
  EXPECT_EQ(parse_grbl("ok\r").type, Type::kOk);
  EXPECT_EQ(parse_grbl("error:9").number, 9);
  EXPECT_EQ(parse_grbl("ALARM:2").type, Type::kAlarm);
  EXPECT_EQ(parse_grbl("Grbl 1.1h ['$' for help]").text, "1.1h");
  EXPECT_EQ(parse_grbl("[MSG:'$H'|'$X' to unlock]").type, Type::kFeedback);
  const GrblMessage setting = parse_grbl("$100=160.000");
  EXPECT_EQ(setting.number, 100);
  EXPECT_EQ(setting.value, 160);
  const GrblMessage status =
      parse_grbl("<Hold:0|MPos:-83.500,0.000,-1.5|Bf:15,128|FS:0,0|WCO:0,0,0>");
  EXPECT_EQ(status.type, Type::kStatus);
  EXPECT_EQ(status.text, "Hold:0");
  EXPECT_EQ(status.mpos, (std::vector{-83.5, 0.0, -1.5}));
  EXPECT_TRUE(parse_grbl("<Idle|WPos:0,0,0|FS:0,0>").mpos.empty());
}

TEST(GrblMessage, TakesNothingElseForOne) {
  for (const char* text : {"",
                           "OK",
                           "ok ok",
                           "error:",
                           "error:x",
                           "error:-1",
                           "error:9x",
                           "ALARM:99999999999",
                           "<>",
                           "<Idle>",
                           "<Moon|MPos:0,0,0>",
                           "<Idle|MPos:0,,0>",
                           "<Idle|MPos:0,a>",
                           "<Idle|MPos:nan,0>",
                           "<Idle|MPos:1|MPos:2>",
                           "$=1",
                           "$x=1",
                           "$1=",
                           "$1=inf",
                           "\xff\xfe",
                           "<Idle|MPos:1,2,3,4,5,6,7>"})
    EXPECT_EQ(parse_grbl(text).type, Type::kOther) << text;
}

TEST(GrblMessage, SurvivesAnyBytes) {
  const std::vector<std::string> seeds = {"ok",
                                          "error:9",
                                          "ALARM:2",
                                          "$100=160.000",
                                          "<Run|MPos:-1.000,2.000,3.000|FS:500,0>",
                                          "[MSG:x]",
                                          "Grbl 1.1h ['$' for help]"};
  RandomStream random(3, 0);
  const auto below = [&](std::size_t n) {
    return static_cast<std::size_t>(random.uniform() * static_cast<double>(n));
  };
  std::size_t understood = 0;
  for (int i = 0; i < 1'000'000; ++i) {
    std::string text = seeds[below(seeds.size())];
    for (std::size_t n = below(4); n > 0; --n) {
      switch (below(3)) {
        case 0:
          text[below(text.size())] = static_cast<char>(random.next());
          break;
        case 1:
          text.insert(below(text.size()), 1, static_cast<char>(random.next()));
          break;
        default:
          text += seeds[below(seeds.size())];
      }
    }
    const GrblMessage message = parse_grbl(text);
    understood += message.type != Type::kOther;
    ASSERT_LE(message.mpos.size(), 6U);
  }
  EXPECT_GT(understood, 200'000U) << "the mutations reach the parser's inside";
}

}  // namespace
}  // namespace wheatstone
