#include "hardware/serial/photodiode.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "hardware/serial/photodiode_message.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr std::size_t kLongestAnswer = 120;
constexpr int kRoundTrips = 5;
constexpr std::uint32_t kMostSamplesPerS = 1'000'000;
constexpr Nanoseconds kLongestLeadNs = 10'000'000;  // from the command to the first sample
constexpr std::string_view kIdentity = "PHOTODIODE/1 ", kStopped = "STOPPED\n";

const std::filesystem::path& address(const SerialPhotodiodeSettings& s) {
  if (s.line.empty())
    throw ArgumentError("a photodiode has no address", "name its link in /dev/serial/by-id");
  return s.line;
}

}  // namespace

SerialPhotodiode::SerialPhotodiode(const SerialPhotodiodeSettings& settings,
                                   std::shared_ptr<Transcript> transcript)
    : port_("the photodiode at " + address(settings).string(), settings.line, settings.baud,
            std::move(transcript)) {
  const Deadline soon = SteadyClock().in(settings.answer);
  end_recording(soon);  // of a program that was killed
  const std::string answer = ask("ID", soon);
  // "PHOTODIODE/1 <serial> <samples per s>"
  const std::size_t space = answer.rfind(' ');
  if (!answer.starts_with(kIdentity) || space < kIdentity.size())
    throw DeviceError(Kind::kProtocol,
                      fmt::format("{} does not say that it is a photodiode of protocol 1: {}",
                                  port_.what(), printable(answer)),
                      "check that this is the right device, and its firmware");
  identity_ = {"serial photodiode", "PHOTODIODE/1",
               printable(answer.substr(kIdentity.size(), space - kIdentity.size())), "",
               port_.path().string()};
  samples_per_s_ = numbers_of(port_.what(), answer.substr(space), "", 1)[0];
  if (samples_per_s_ == 0 || samples_per_s_ > kMostSamplesPerS)
    throw DeviceError(
        Kind::kFault,
        fmt::format("{} says that it takes {} samples/s", port_.what(), samples_per_s_),
        "check its firmware");
  if (!settings.serial.empty() && identity_.serial != settings.serial)
    throw DeviceError(Kind::kFault,
                      fmt::format("{} has the serial '{}' and not '{}'", port_.what(),
                                  identity_.serial, settings.serial),
                      "correct its serial or its address in the rig file");
}

SerialPhotodiode::~SerialPhotodiode() {
  if (recording_) port_.write_now("STOP\n");
}

std::string SerialPhotodiode::ask(const std::string& question, const Deadline& deadline) {
  port_.write(question + "\n", deadline);
  return port_.read_line('\n', kLongestAnswer, deadline);
}

void SerialPhotodiode::end_recording(const Deadline& deadline) {
  port_.discard_input();
  port_.write("STOP\n", deadline);
  // Samples may look like its answer, but the answer comes last.
  std::string tail;
  while (!tail.ends_with(kStopped)) {
    tail += port_.read(deadline);
    if (tail.size() > kLongestAnswer) tail.erase(0, tail.size() - kLongestAnswer);
  }
  recording_ = false;
}

SerialPhotodiode::Sync SerialPhotodiode::synchronise(const Deadline& deadline) {
  const SteadyClock clock;
  Sync best;
  for (int i = 0; i < kRoundTrips; ++i) {
    const Nanoseconds asked = clock.now_ns();
    const std::string answer = ask(fmt::format("TIME {}", ++tag_), deadline);
    const Nanoseconds took = clock.now_ns() - asked;
    const auto numbers = numbers_of(port_.what(), answer, "TIME", 2);
    if (numbers[0] != tag_)
      throw DeviceError(Kind::kProtocol,
                        port_.what() + " answers an earlier question: " + printable(answer),
                        "run the command again");
    if (i == 0 || took < best.round_trip_ns) best = {asked + took / 2, took, numbers[1]};
  }
  return best;
}

LightTrace SerialPhotodiode::record(Duration duration, Deadline deadline) {
  const double count = std::round(duration.value() * samples_per_s_);
  if (!(count >= 1 && count <= kMostSamples))
    throw DeviceError(Kind::kOutOfRange,
                      fmt::format("{} cannot record for {:g} s", port_.what(), duration.value()),
                      fmt::format("use {:g} s to {:g} s", 1.0 / samples_per_s_,
                                  double(kMostSamples) / samples_per_s_));
  if (recording_)
    end_recording(deadline);
  else
    port_.discard_input();
  const Sync sync = synchronise(deadline);
  LightTrace trace;
  trace.samples_per_s = samples_per_s_;
  recording_ = true;  // until the last sample is here, an error leaves us not knowing
  const SteadyClock clock;
  const Nanoseconds asked = clock.now_ns();
  const std::string answer = ask(fmt::format("RECORD {:.0f}", count), deadline);
  const Nanoseconds answered = clock.now_ns();
  const std::uint32_t start_us = numbers_of(port_.what(), answer, "RECORD", 1)[0];
  // Its microseconds wrap.
  trace.start_ns =
      sync.host_ns + Nanoseconds{1000} * static_cast<std::int32_t>(start_us - sync.device_us);
  const Nanoseconds slack = kLongestLeadNs + sync.round_trip_ns;
  if (trace.start_ns < asked - slack || trace.start_ns > answered + slack)
    throw DeviceError(Kind::kFault,
                      fmt::format("{} says that it began {:+.3f} s from the command", port_.what(),
                                  1e-9 * double(trace.start_ns - asked)),
                      "its clock was set or it was switched on again: record again");
  receive(trace, static_cast<std::size_t>(count), deadline);
  recording_ = false;
  for (const float level : trace.levels)
    if (level >= 1)
      throw DeviceError(Kind::kTooBright, port_.what() + " is saturated",
                        "show darker patches, or cover the sensor in part");
  return trace;
}

void SerialPhotodiode::receive(LightTrace& trace, std::size_t count, const Deadline& deadline) {
  std::string bytes;
  std::uint8_t expected = 0;
  while (trace.levels.size() < count) {
    bytes += port_.read(deadline);
    for (const PhotodiodeBlock& block : take_blocks(port_.what(), bytes)) {
      if (block.sequence != expected++)
        throw DeviceError(Kind::kFault, port_.what() + " lost samples",
                          "use a faster line or an idle machine, then record again");
      for (const std::uint16_t s : block.samples)
        trace.levels.push_back(static_cast<float>(s) / 65535.0F);
    }
    if (SteadyClock().now_ns() >= deadline.at_ns && trace.levels.size() < count)
      throw DeviceError(Kind::kTimeout, port_.what() + " did not send all samples in time",
                        "allow more than the time of the recording");
  }
  if (trace.levels.size() > count || !bytes.empty())
    throw DeviceError(Kind::kProtocol, port_.what() + " sends more samples than it was asked for",
                      "check its firmware");
}

}  // namespace wheatstone
