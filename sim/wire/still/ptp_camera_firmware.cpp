#include "sim/wire/still/ptp_camera_firmware.h"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <utility>

#include "sim/wire/still/dng.h"
#include "sim/wire/still/little_endian.h"

namespace wheatstone {
namespace {

constexpr std::uint32_t kStorage = 0x00010001;
constexpr std::uint16_t kSonyRaw = 0xb101;
constexpr std::uint16_t kSonyVendor = 0x11;
constexpr double kReadoutS = 0.02;
constexpr std::size_t kLongestEventQueue = 32;

bool has_data_phase(std::uint16_t operation) {
  return operation == ptp::kSetValue || operation == ptp::kControl;
}

std::uint32_t parameter(const PtpContainer& c, std::size_t i) {
  return i < c.parameters.size() ? c.parameters[i] : 0;
}

bool same_time(std::uint32_t a, std::uint32_t b) {
  return std::uint64_t{a >> 16} * (b & 0xffff) == std::uint64_t{b >> 16} * (a & 0xffff);
}

PtpReply refuse(std::uint16_t code) {
  return {code, {}, std::nullopt};
}

}  // namespace

PtpCameraFirmware::PtpCameraFirmware(World& world, PtpCameraOptions options)
    : world_(world),
      options_(std::move(options)),
      camera_(world, options_.noise),
      properties_(camera_properties(options_.settable_shutter)) {
  if (options_.serial.empty()) options_.serial = world.camera_profile.serial;
}

void PtpCameraFirmware::reset() {
  session_ = 0;
  command_.reset();
  assembler_.clear();
  out_.clear();
  events_.clear();
  halted_ = false;
}

void PtpCameraFirmware::receive(std::span<const std::byte> transfer, Nanoseconds now) {
  if (halted_ || silent) return;
  advance(now);
  const PtpAssembler::State state = assembler_.feed(transfer);
  if (state == PtpAssembler::State::kWaiting) return;
  const PtpContainer& c = assembler_.container();
  const bool data_expected = command_.has_value();
  // A command in place of data takes back the one before.
  const bool data = state == PtpAssembler::State::kWhole && c.type == PtpType::kData;
  if (state == PtpAssembler::State::kMalformed || (data && !data_expected)) {
    command_.reset();
    out_.clear();
    halted_ = true;
    return;
  }
  if (data) {
    const PtpContainer command = *std::exchange(command_, std::nullopt);
    if (c.code != command.code || c.transaction != command.transaction)
      answer(command, refuse(ptp::kGeneralError), now);
    else
      answer(command, execute(command, c.data, now), now);
    return;
  }
  out_.clear();  // nobody fetches the answer to an earlier command
  command_.reset();
  if (has_data_phase(c.code))
    command_ = c;
  else
    answer(c, execute(c, {}, now), now);
}

PtpReply PtpCameraFirmware::execute(const PtpContainer& c, std::span<const std::byte> data,
                                    Nanoseconds now) {
  if (c.code == ptp::kGetDeviceInfo) return device_info();
  if (c.code == ptp::kOpenSession) {
    if (parameter(c, 0) == 0) return refuse(ptp::kBadParameter);
    if (session_ != 0) return {ptp::kSessionOpen, {session_}, std::nullopt};
    session_ = parameter(c, 0);
    return {};
  }
  if (session_ == 0) return refuse(ptp::kSessionNotOpen);
  PtpReply reply;
  reply.data.emplace();
  switch (c.code) {
    case ptp::kCloseSession:
      session_ = 0;
      return {};
    case ptp::kGetStorageIds:
      append(*reply.data, std::uint32_t{1});
      append(*reply.data, kStorage);
      return reply;
    case ptp::kGetStorageInfo:
      if (parameter(c, 0) != kStorage) return refuse(ptp::kBadStorage);
      append(*reply.data, std::uint16_t{4});  // removable RAM
      append(*reply.data, std::uint16_t{2});  // generic hierarchical
      append(*reply.data, std::uint16_t{0});  // read and write
      append(*reply.data, std::uint64_t{64} << 30);
      append(*reply.data, full ? std::uint64_t{0} : std::uint64_t{32} << 30);
      append(*reply.data, std::uint32_t{0xffffffff});
      append_ptp_text(*reply.data, "");
      append_ptp_text(*reply.data, "");
      return reply;
    case ptp::kGetObjectHandles:
      append(*reply.data, std::uint32_t{0});  // pictures go to the host, none to the card
      return reply;
    case ptp::kGetObjectInfo:
      if (parameter(c, 0) != ptp::kShot) return refuse(ptp::kBadHandle);
      return object_info(now);
    case ptp::kGetObject:
      if (parameter(c, 0) != ptp::kShot || shots_.empty() || shots_.front().ready_ns > now)
        return refuse(ptp::kBadHandle);
      reply.data = std::move(shots_.front().file);
      shots_.pop_front();
      advance(now);
      return reply;
    case ptp::kDeleteObject:
      return refuse(ptp::kBadHandle);
    case ptp::kConnect:
      append(*reply.data, std::uint64_t{0});
      return parameter(c, 0) >= 1 && parameter(c, 0) <= 3 ? reply : refuse(ptp::kBadParameter);
    case ptp::kExtendedInfo:
      return extended_info();
    case ptp::kAllProperties:
      reply.data = property_list(properties_);
      return reply;
    case ptp::kSetValue:
    case ptp::kControl:
      return set(parameter(c, 0), data, c.code == ptp::kControl, now);
    default:
      return refuse(ptp::kUnsupported);
  }
}

PtpReply PtpCameraFirmware::device_info() const {
  PtpReply reply;
  std::vector<std::byte>& out = reply.data.emplace();
  append(out, std::uint16_t{100});  // of the standard
  append(out, std::uint32_t{kSonyVendor});
  append(out, std::uint16_t{100});
  append_ptp_text(out, "sony.net/SEN_PRXY_MTP:100");
  append(out, std::uint16_t{0});
  append_ptp_codes(out, {ptp::kGetDeviceInfo, ptp::kOpenSession, ptp::kCloseSession,
                         ptp::kGetStorageIds, ptp::kGetStorageInfo, ptp::kGetObjectHandles,
                         ptp::kGetObjectInfo, ptp::kGetObject, ptp::kDeleteObject, ptp::kConnect,
                         ptp::kExtendedInfo, ptp::kSetValue, ptp::kControl, ptp::kAllProperties});
  append_ptp_codes(out, {ptp::kObjectAdded, ptp::kPropertyChanged});
  append_ptp_codes(out, {});                  // properties
  append_ptp_codes(out, {});                  // formats it makes
  append_ptp_codes(out, {0x3801, kSonyRaw});  // formats it shows
  append_ptp_text(out, options_.manufacturer);
  append_ptp_text(out, options_.model);
  append_ptp_text(out, options_.version);
  append_ptp_text(out, options_.serial);
  return reply;
}

PtpReply PtpCameraFirmware::extended_info() const {
  PtpReply reply;
  std::vector<std::byte>& out = reply.data.emplace();
  std::vector<std::uint16_t> values, buttons = {ptp::kHalfPress, ptp::kFullPress};
  for (const auto& [code, p] : properties_)
    if (std::find(buttons.begin(), buttons.end(), code) == buttons.end()) values.push_back(code);
  append(out, std::uint16_t{0xc8});
  append_ptp_codes(out, values);
  append_ptp_codes(out, buttons);
  return reply;
}

PtpReply PtpCameraFirmware::object_info(Nanoseconds now) const {
  if (shots_.empty() || shots_.front().ready_ns > now) return refuse(ptp::kBadHandle);
  const Shot& shot = shots_.front();
  PtpReply reply;
  std::vector<std::byte>& out = reply.data.emplace();
  append(out, kStorage);
  append(out, kSonyRaw);
  append(out, std::uint16_t{0});  // not protected
  append(out, static_cast<std::uint32_t>(shot.file.size()));
  append(out, std::uint16_t{0});  // no thumbnail
  for (int i = 0; i < 3; ++i) append(out, std::uint32_t{0});
  append(out, static_cast<std::uint32_t>(shot.width_px));
  append(out, static_cast<std::uint32_t>(shot.height_px));
  append(out, std::uint32_t{16});
  append(out, std::uint32_t{0});  // parent
  append(out, std::uint16_t{0});
  append(out, std::uint32_t{0});
  append(out, std::uint32_t{0});
  append_ptp_text(out, fmt::format("DSC{:05}.ARW", taken_ % 100000));
  append_ptp_text(out, "20260101T000000");
  append_ptp_text(out, "20260101T000000");
  append_ptp_text(out, "");
  return reply;
}

PtpReply PtpCameraFirmware::set(std::uint32_t code, std::span<const std::byte> data, bool button,
                                Nanoseconds now) {
  const auto it =
      code <= 0xffff ? properties_.find(static_cast<std::uint16_t>(code)) : properties_.end();
  if (it == properties_.end()) return refuse(ptp::kBadProperty);
  PtpProperty& p = it->second;
  const bool is_button = code == ptp::kHalfPress || code == ptp::kFullPress;
  if (!p.writable || is_button != button) return refuse(ptp::kBadProperty);
  if (data.size() != p.width()) return refuse(ptp::kBadParameter);
  std::uint32_t value = 0;
  for (std::size_t i = data.size(); i-- > 0;)
    value = value << 8 | std::to_integer<std::uint32_t>(data[i]);
  // The same time in other terms is taken: hosts write 30 s as 30/1, the body lists 300/10.
  const bool is_time = code == ptp::kSettableShutter;
  const auto choice = std::find_if(p.choices.begin(), p.choices.end(), [&](std::uint32_t c) {
    return c == value || (is_time && (value & 0xffff) && same_time(c, value));
  });
  if (choice == p.choices.end()) return refuse(ptp::kBadValue);
  value = *choice;
  if (is_time) {
    if (round_shutter) value = round_shutter(value);
    properties_.at(ptp::kShutter).current = value;
  }
  if (code == ptp::kFullPress && p.current == 1 && value == 2) {
    const PtpReply reply = press(now);
    if (reply.code != ptp::kOk) return reply;
  }
  p.current = value;
  if (!button) event(ptp::kPropertyChanged, code);
  return {};
}

PtpReply PtpCameraFirmware::press(Nanoseconds now) {
  if (full) return refuse(ptp::kStoreFull);
  if (exposing(now) || shots_.size() >= options_.memory_pictures) return refuse(ptp::kBusy);
  if (!takes_nothing) take_picture(now);
  return {};
}

void PtpCameraFirmware::take_picture(Nanoseconds now) {
  const std::uint32_t code = shutter_code();
  const double exposure_s = seconds_of(code);
  const std::scoped_lock lock(world_.mutex);
  const Duration exposure = Duration::of(exposure_s);
  const RawFrame frame =
      camera_.expose(exposure, world_.clock.in(2 * camera_.frame_duration(exposure)));
  DngPicture picture{frame.mosaic,
                     world_.camera_profile.black_dn,
                     world_.camera_profile.white_dn,
                     code >> 16,
                     code & 0xffff,
                     static_cast<int>(properties_.at(ptp::kIso).current),
                     options_.manufacturer,
                     options_.model,
                     options_.serial};
  Shot shot{dng_file(picture), frame.mosaic.width(), frame.mosaic.height(), 0, false};
  if (spoil_file) spoil_file(shot.file);
  shot.ready_ns =
      now + static_cast<Nanoseconds>((exposure_s + kReadoutS) / options_.time_scale * 1e9);
  shots_.push_back(std::move(shot));
  ++taken_;
}

void PtpCameraFirmware::answer(const PtpContainer& command, PtpReply reply, Nanoseconds now) {
  if (spoil) spoil(command.code, reply);
  if (silent) return;
  const auto send = [&](PtpContainer c) {
    std::vector<std::byte> bytes = encode(c);
    if (spoil_bytes) spoil_bytes(bytes);
    out_.push_back({std::move(bytes), 0});
  };
  if (reply.data && reply.code == ptp::kOk)
    send({PtpType::kData, command.code, command.transaction, {}, std::move(*reply.data)});
  send({PtpType::kResponse, reply.code, command.transaction, reply.parameters, {}});
  advance(now);
}

void PtpCameraFirmware::event(std::uint16_t code, std::uint32_t parameter) {
  if (events_.size() >= kLongestEventQueue) events_.pop_front();
  events_.push_back(encode({PtpType::kEvent, code, 0xffffffff, {parameter}, {}}));
}

void PtpCameraFirmware::advance(Nanoseconds now) {
  std::uint32_t ready = 0;
  for (Shot& shot : shots_) {
    if (shot.ready_ns > now) continue;
    ++ready;
    if (!std::exchange(shot.announced, true)) event(ptp::kObjectAdded, ptp::kShot);
  }
  properties_.at(ptp::kObjectsWaiting).current = ready > 0 ? 0x8000 + ready : 0;
}

Nanoseconds PtpCameraFirmware::next_event() const {
  Nanoseconds next = kNever;
  for (const Shot& shot : shots_)
    if (!shot.announced) next = std::min(next, shot.ready_ns);
  return next;
}

std::optional<std::vector<std::byte>> PtpCameraFirmware::bulk_in(std::size_t most,
                                                                 Nanoseconds now) {
  advance(now);
  if (silent || halted_ || out_.empty() || cut_after == 0) return std::nullopt;
  Transfer& transfer = out_.front();
  const std::size_t n = std::min({most, transfer.bytes.size() - transfer.sent, cut_after});
  const auto first = transfer.bytes.begin() + static_cast<std::ptrdiff_t>(transfer.sent);
  std::vector<std::byte> out(first, first + static_cast<std::ptrdiff_t>(n));
  transfer.sent += n;
  if (cut_after != SIZE_MAX) cut_after -= n;
  // A container of whole packets that fills the host's request is followed by an empty packet.
  const bool over = transfer.sent == transfer.bytes.size() &&
                    (n < most || transfer.bytes.size() % kPacketBytes != 0);
  if (over) out_.pop_front();
  return out;
}

std::optional<std::vector<std::byte>> PtpCameraFirmware::interrupt_in(Nanoseconds now) {
  advance(now);
  if (silent || events_.empty()) return std::nullopt;
  std::vector<std::byte> out = std::move(events_.front());
  events_.pop_front();
  return out;
}

}  // namespace wheatstone
