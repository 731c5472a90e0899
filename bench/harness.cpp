#include "bench/harness.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "core/error.h"
#include "core/json.h"
#include "core/memory.h"

namespace wheatstone::bench {
namespace {

struct Ratio {
  std::string name, numerator, denominator;
};
std::vector<Ratio>& ratios() {
  static std::vector<Ratio> all;
  return all;
}
std::map<std::string, double>& figures() {
  static std::map<std::string, double> all;
  return all;
}

/// Prints as usual and keeps the aggregates, in ms.
class KeepingReporter : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (run.error_occurred)
        failed_.push_back(run.benchmark_name() + ": " + run.error_message);
      else if (run.run_type == Run::RT_Aggregate)
        aggregates[run.run_name.str()][run.aggregate_name] =
            run.aggregate_name == "cv"
                ? run.real_accumulated_time
                : run.GetAdjustedRealTime() * 1e3 / benchmark::GetTimeUnitMultiplier(run.time_unit);
    }
    ConsoleReporter::ReportRuns(runs);
  }
  const std::vector<std::string>& failed() const { return failed_; }

  std::map<std::string, std::map<std::string, double>> aggregates;  // case -> median, cv, ...

 private:
  std::vector<std::string> failed_;
};

std::string cpu_name() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.starts_with("model name")) return line.substr(line.find(": ") + 2);
  return "unknown";
}

int run(int argc, char** argv) {
  std::string json_path;
  // Defaults first, so that the command line overrides them.
  static char interleave[] = "--benchmark_enable_random_interleaving=true",
              repetitions[] = "--benchmark_repetitions=9",
              aggregates[] = "--benchmark_display_aggregates_only=true",
              min_time[] = "--benchmark_min_time=0.1";
  std::vector<char*> arguments = {argv[0], interleave, repetitions, aggregates, min_time};
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--json") == 0 && i + 1 < argc)
      json_path = argv[++i];
    else
      arguments.push_back(argv[i]);
  }
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;
  KeepingReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  if (!reporter.failed().empty()) {
    for (const std::string& f : reporter.failed()) fmt::print(stderr, "failed: {}\n", f);
    return 1;
  }

  nlohmann::json out;
  out["machine"] = {{"cpu", cpu_name()}, {"cores", std::thread::hardware_concurrency()}};
  for (const auto& [name, values] : reporter.aggregates)
    out["cases"][name] = {{"median_ms", values.at("median")}, {"cv", values.at("cv")}};
  for (const Ratio& r : ratios()) {
    const auto a = reporter.aggregates.find(r.numerator),
               b = reporter.aggregates.find(r.denominator);
    if (a == reporter.aggregates.end() || b == reporter.aggregates.end()) continue;  // filtered out
    out["ratios"][r.name] = a->second.at("median") / b->second.at("median");
    fmt::print("{} = {:.4g}\n", r.name, out["ratios"][r.name].get<double>());
  }
  for (const auto& [name, value] : figures()) {
    out["figures"][name] = value;
    fmt::print("{} = {:.6g}\n", name, value);
  }
  if (!json_path.empty()) write_json(json_path, "wheatstone-bench/1", out);
  return 0;
}

}  // namespace

bool add_ratio(const std::string& name, const std::string& numerator,
               const std::string& denominator) {
  ratios().push_back({name, numerator, denominator});
  return true;
}

void add_figure(const std::string& name, double value) {
  figures()[name] = value;
}

}  // namespace wheatstone::bench

int main(int argc, char** argv) {
  wheatstone::keep_freed_memory();  // as the program does
  try {
    return wheatstone::bench::run(argc, argv);
  } catch (const wheatstone::Error& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
}
