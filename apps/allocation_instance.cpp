#include "apps/allocation_instance.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/json.h"

namespace wheatstone::apps {
namespace {

using nlohmann::json;

constexpr std::int64_t kMaxTiles = 1'000'000;

/// One instance of a file, with errors that name both.
class InstanceReader {
 public:
  InstanceReader(std::filesystem::path path, const json& instance)
      : path_(std::move(path)), instance_(instance) {}

  AllocationProblem read() const {
    AllocationProblem out;
    out.budget = get<std::int64_t>("budget", 0, std::int64_t{1} << 53);
    const json& costs = array("bandwidth");
    if (costs.size() != kShadingRateCount)
      refuse(fmt::format("\"bandwidth\" has {} costs", costs.size()), "give one for each rate");
    for (int k = 0; k < kShadingRateCount; ++k)
      out.cost[k] = static_cast<int>(whole(costs[k], "a cost in \"bandwidth\"", 1, 1'000'000));
    out.quality = instance_.contains("quality") ? given_quality() : drawn_quality();
    return out;
  }

 private:
  [[noreturn]] void refuse(const std::string& problem, const std::string& remedy) const {
    throw FileError(path_, problem, remedy);
  }

  const json& key(const char* name) const {
    if (!instance_.is_object() || !instance_.contains(name))
      refuse(fmt::format("has no \"{}\"", name),
             "give an instance as docs/shading_rates.md describes it");
    return instance_.at(name);
  }

  const json& array(const char* name) const {
    if (!key(name).is_array()) refuse(fmt::format("\"{}\" is no list", name), "give a list");
    return key(name);
  }

  std::int64_t whole(const json& value, const std::string& what, std::int64_t low,
                     std::int64_t high) const {
    const double v = value.is_number() ? value.get<double>() : std::nan("");
    if (!(v >= static_cast<double>(low) && v <= static_cast<double>(high)) || v != std::floor(v))
      refuse(fmt::format("{} is {}", what, value.dump()),
             fmt::format("give a whole number from {} to {}", low, high));
    return static_cast<std::int64_t>(v);
  }

  template <class Integer>
  Integer get(const char* name, std::int64_t low, std::int64_t high) const {
    return static_cast<Integer>(whole(key(name), fmt::format("\"{}\"", name), low, high));
  }

  std::int64_t tiles() const {
    const auto x = get<std::int64_t>("tiles_x", 1, kMaxTiles);
    const auto y = get<std::int64_t>("tiles_y", 1, kMaxTiles);
    if (x * y > kMaxTiles)
      refuse(fmt::format("{} x {} tiles are too many", x, y), "give at most 1000000");
    return x * y;
  }

  std::vector<double> given_quality() const {
    const json& rows = array("quality");
    if ((instance_.contains("tiles_x") || instance_.contains("tiles_y")) &&
        static_cast<std::int64_t>(rows.size()) != tiles())
      refuse(fmt::format("\"quality\" has {} tiles instead of tiles_x x tiles_y", rows.size()),
             "give one row for each tile");
    std::vector<double> out;
    for (std::size_t tile = 0; tile < rows.size(); ++tile) {
      if (!rows[tile].is_array() || rows[tile].size() != kShadingRateCount)
        refuse(fmt::format("the quality of tile {} is not a list of seven", tile),
               "give one number for each rate");
      for (const json& q : rows[tile]) {
        if (!q.is_number())
          refuse(fmt::format("a quality of tile {} is {}", tile, q.dump()), "give finite numbers");
        out.push_back(q.get<double>());
      }
    }
    return out;
  }

  /// The recipe of the reference vectors: four draws of a linear congruential generator per tile.
  std::vector<double> drawn_quality() const {
    if (!instance_.contains("lcg_seed"))
      refuse("has neither \"quality\" nor \"lcg_seed\"", "give one of them");
    auto state = get<std::uint32_t>("lcg_seed", 0, 0xffffffffLL);
    const auto mode = get<int>("mode", 0, 2);
    const auto draw = [&] {
      state = 1664525u * state + 1013904223u;
      const double u = state * 0x1p-32;
      return mode == 1 ? std::floor(4 * u) / 4 : u;
    };
    const double offset = mode == 2 ? 0.75 : 0;
    std::vector<double> out;
    for (std::int64_t tile = tiles(); tile > 0; --tile) {
      const double hx = 3 * draw() - offset, fx = hx + 4 * draw() - offset;
      const double hy = 3 * draw() - offset, fy = hy + 4 * draw() - offset;
      for (const double q :
           {0.0, hx / 2, hy / 2, (hx + hy) / 2, (fx + hy) / 2, (hx + fy) / 2, (fx + fy) / 2})
        out.push_back(q + 0.1);
    }
    return out;
  }

  const std::filesystem::path path_;
  const json& instance_;
};

std::string name_of(const json& instance) {
  return instance.is_object() && instance.contains("name") && instance["name"].is_string()
             ? instance["name"].get<std::string>()
             : "";
}

}  // namespace

AllocationProblem read_allocation_instance(const std::filesystem::path& path,
                                           const std::string& name) {
  const json document = read_json(path);
  if (!document.is_object() || !document.contains("instances"))
    return InstanceReader(path, document).read();
  std::string names;
  if (document["instances"].is_array())
    for (const json& instance : document["instances"]) {
      if (!name.empty() && name_of(instance) == name) return InstanceReader(path, instance).read();
      names += (names.empty() ? "" : ", ") + name_of(instance);
    }
  throw FileError(path,
                  name.empty() ? "holds a list of instances" : "holds no instance '" + name + "'",
                  "name one with --instance: " + names);
}

void write_allocation(const std::filesystem::path& path, const std::string& solver,
                      const AllocationProblem& problem, const Allocation& allocation) {
  write_json(path, "wheatstone-allocation/1",
             {{"solver", solver},
              {"total_quality", allocation.total_quality},
              {"total_cost", allocation.total_cost},
              {"budget", problem.budget},
              {"gap_bound", allocation.gap_bound},
              {"choice", allocation.choice}});
}

}  // namespace wheatstone::apps
