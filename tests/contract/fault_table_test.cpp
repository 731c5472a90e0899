// docs/hardware/faults.md is written from the tables that the contract tests carry out.
//   WHEATSTONE_WRITE_FAULT_TABLE=1 bin/fault_table_test     writes it anew

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <set>
#include <span>
#include <tuple>
#include <vector>

#include "core/files.h"
#include "tests/contract/all_faults.h"

namespace wheatstone {
namespace {

std::string table_of(const std::vector<std::span<const FaultCase>>& drivers) {
  std::string text =
      "# Faults\n\n"
      "What each driver does when something goes wrong: how the call ends and what the device "
      "object\n"
      "then says of itself. Written from the tables that the contract tests carry out\n"
      "(`ctest -L contract`); do not edit.\n\n"
      "| driver | fault | while | ends with | then |\n|---|---|---|---|---|\n";
  for (const auto& driver : drivers)
    for (const FaultCase& c : driver)
      text += std::string("| ") + c.driver + " | " + c.fault + " | " + c.state + " | " +
              to_string(c.error) + " | " + c.after + " |\n";
  return text;
}

TEST(FaultTable, HasEveryCaseOnce) {
  std::set<std::tuple<std::string, std::string, std::string>> distinct;
  std::size_t cases = 0;
  for (const auto& driver : all_faults())
    for (const FaultCase& c : driver) {
      ++cases;
      EXPECT_TRUE(distinct.insert({c.driver, c.fault, c.state}).second)
          << c.driver << ", " << c.fault << ", " << c.state;
    }
  EXPECT_EQ(distinct.size(), cases);
  RecordProperty("cases", static_cast<int>(cases));
}

TEST(FaultTable, IsTheOneInTheManual) {
  const std::filesystem::path file =
      std::filesystem::path(WHEATSTONE_SOURCE_DIR) / "docs/hardware/faults.md";
  if (std::getenv("WHEATSTONE_WRITE_FAULT_TABLE"))
    write_text_atomically(file, table_of(all_faults()));
  EXPECT_EQ(read_text(file), table_of(all_faults()))
      << "run it with WHEATSTONE_WRITE_FAULT_TABLE=1";
}

}  // namespace
}  // namespace wheatstone
