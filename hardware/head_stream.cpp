#include "hardware/head_stream.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/json.h"
#include "hardware/transport/transcript.h"

namespace wheatstone {
namespace {

using Json = nlohmann::json;
using Kind = DeviceError::Kind;

constexpr int kVersion = 1;
constexpr double kFarthestMm = 10'000;
constexpr std::int32_t kLatestNumbers = 1000;  // farther back: the tracker started anew
constexpr std::int64_t kLongestAgeUs = 10'000'000;

double number(const Json& j) {
  if (!j.is_number()) throw std::invalid_argument("something is no number");
  const auto v = j.get<double>();
  if (!std::isfinite(v)) throw std::invalid_argument("a number is not finite");
  return v;
}

std::int64_t integer(const Json& sample, const char* key, std::int64_t most) {
  const Json& j = sample.at(key);
  if (!j.is_number_integer() || j.get<std::int64_t>() < 0 || j.get<std::int64_t>() > most)
    throw std::invalid_argument(fmt::format("{} is not in 0..{}", key, most));
  return j.get<std::int64_t>();
}

template <class Use>
void three(const Json& j, const Use& use) {
  if (!j.is_array() || j.size() != 3) throw std::invalid_argument("a list has not 3 entries");
  for (int i = 0; i < 3; ++i) use(i, j[static_cast<std::size_t>(i)]);
}

std::optional<EyeCentre> eye(const Json& j) {
  if (j.is_null()) return {};
  EyeCentre out;
  three(j.at("p_rsb_mm"), [&](int i, const Json& v) { out.p_rsb_mm[i] = number(v); });
  three(j.at("covariance_mm2"), [&](int i, const Json& row) {
    three(row, [&](int k, const Json& v) { out.covariance_mm2(i, k) = number(v); });
  });
  out.confidence = number(j.at("confidence"));
  if (out.p_rsb_mm.cwiseAbs().maxCoeff() > kFarthestMm)
    throw std::invalid_argument("an eye is farther than 10 m");
  if (out.covariance_mm2.cwiseAbs().maxCoeff() > kFarthestMm * kFarthestMm)
    throw std::invalid_argument("a covariance is larger than (10 m)^2");
  if (!(out.confidence >= 0 && out.confidence <= 1))
    throw std::invalid_argument("a confidence is not in 0..1");
  const Eigen::Matrix3d& c = out.covariance_mm2;
  const double allowed = 1e-9 * (1 + c.cwiseAbs().maxCoeff());
  if ((c - c.transpose()).cwiseAbs().maxCoeff() > allowed ||
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(c, Eigen::EigenvaluesOnly)
              .eigenvalues()
              .minCoeff() < -allowed)
    throw std::invalid_argument("a covariance is none");
  return out;
}

Json to_json_or_null(const std::optional<EyeCentre>& e) {
  if (!e) return nullptr;
  return {{"p_rsb_mm", to_json(e->p_rsb_mm)},
          {"covariance_mm2", to_json(Eigen::MatrixXd(e->covariance_mm2))},
          {"confidence", e->confidence}};
}

}  // namespace

HeadSample parse_head_sample(const std::string& what, std::string_view line) {
  try {
    if (line.size() > kLongestHeadSample) throw std::invalid_argument("it is too long");
    const Json j = Json::parse(line);
    if (j.at("wheatstone_eyes") != kVersion) throw std::invalid_argument("of another version");
    HeadSample s;
    s.tracker = j.at("tracker").get<std::string>();
    s.number = static_cast<std::uint32_t>(integer(j, "n", 0xffffffff));
    s.exposed_us = integer(j, "exposed_us", std::int64_t{1} << 53);
    s.sent_us = integer(j, "sent_us", std::int64_t{1} << 53);
    if (s.sent_us < s.exposed_us || s.sent_us - s.exposed_us > kLongestAgeUs)
      throw std::invalid_argument("it was not sent within 10 s of its exposure");
    s.eyes = {eye(j.at("left")), eye(j.at("right"))};
    return s;
  } catch (const std::exception& e) {
    // What the parser says may quote bytes that are no text.
    const bool parser = dynamic_cast<const Json::exception*>(&e) != nullptr;
    throw DeviceError(Kind::kProtocol,
                      fmt::format("{} sends a sample that is none ({}): {}", what,
                                  parser ? "no JSON, or a key is missing" : e.what(), hex_of(line)),
                      "check that it is a head tracker, of this version");
  }
}

std::string to_line(const HeadSample& s) {
  const Json j = {{"wheatstone_eyes", kVersion},
                  {"tracker", s.tracker},
                  {"n", s.number},
                  {"exposed_us", s.exposed_us},
                  {"sent_us", s.sent_us},
                  {"left", to_json_or_null(s.eyes[0])},
                  {"right", to_json_or_null(s.eyes[1])}};
  return j.dump();
}

Nanoseconds TrackerClock::exposed_ns(const HeadSample& s, Nanoseconds read_ns) {
  const Nanoseconds seen_ns = read_ns - 1000 * s.sent_us;  // the offset, and the delay of this one
  if (offset_ns_) {
    // Upwards it follows no faster than the clocks can drift.
    *offset_ns_ += static_cast<Nanoseconds>(
        1e-6 * kDriftPpm * static_cast<double>(std::max<Nanoseconds>(0, read_ns - last_read_ns_)));
    offset_ns_ = std::min(*offset_ns_, seen_ns);
  } else {
    offset_ns_ = seen_ns;
  }
  last_read_ns_ = read_ns;
  return 1000 * s.exposed_us + *offset_ns_;
}

void StreamedHeadTracker::take(const HeadSample& s, Nanoseconds read_ns) {
  if (!serial_.empty() && s.tracker != serial_)
    throw DeviceError(
        Kind::kFault,
        fmt::format("{} hears the tracker '{}' and not '{}'", what_, s.tracker, serial_),
        "correct the serial or the address of the tracker in the rig file");
  const auto ahead = static_cast<std::int32_t>(s.number - number_);
  if (any_ && ahead <= 0 && ahead > -kLatestNumbers) return;
  if (any_ && (ahead <= 0 || s.exposed_us < exposed_us_)) clock_.forget();
  any_ = true;
  number_ = s.number;
  exposed_us_ = s.exposed_us;
  tracker_ = s.tracker;
  newest_ = EyeCentres{s.eyes, clock_.exposed_ns(s, read_ns)};
}

EyeCentres StreamedHeadTracker::next(Deadline deadline) {
  for (;;) {
    if (deadline.cancel.stop_requested()) throw Cancelled(what_ + ": stopped on request");
    if (SteadyClock().now_ns() >= deadline.at_ns)
      throw DeviceError(Kind::kTimeout, what_ + " sends nothing new",
                        "check that it sees the observer and runs");
    std::optional<DeviceError> bad;
    const std::vector<std::string> received = lines(deadline);
    const Nanoseconds now = SteadyClock().now_ns();
    for (const std::string& line : received) {
      try {
        take(parse_head_sample(what_, line), now);
      } catch (const DeviceError& e) {
        bad = e;
      }
    }
    if (newest_) return *std::exchange(newest_, {});
    if (bad) throw *bad;
  }
}

}  // namespace wheatstone
