#include "hardware/usb/usb_device.h"

#include <fmt/format.h>
#include <libusb.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <mutex>
#include <utility>

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr Nanoseconds kStopCheckNs = 40'000'000, kAtOnceNs = 250'000'000;

struct Exit {
  void operator()(libusb_context* c) const { libusb_exit(c); }
};
using Context = std::unique_ptr<libusb_context, Exit>;

struct Close {
  void operator()(libusb_device_handle* h) const { libusb_close(h); }
};
using Handle = std::unique_ptr<libusb_device_handle, Close>;

struct FreeTransfer {
  void operator()(libusb_transfer* t) const { libusb_free_transfer(t); }
};
using Transfer = std::unique_ptr<libusb_transfer, FreeTransfer>;

Context new_context() {
  libusb_context* context = nullptr;
  if (const int r = libusb_init(&context))
    throw DeviceError(Kind::kFault, fmt::format("libusb does not start ({})", libusb_error_name(r)),
                      "check that the machine has a USB controller");
  return Context(context);
}

Transfer new_transfer() {
  Transfer transfer(libusb_alloc_transfer(0));
  if (!transfer) throw DeviceError(Kind::kFault, "no USB transfer can be had", "free some memory");
  return transfer;
}

Kind kind_of_error(int error) {
  switch (error) {
    case LIBUSB_ERROR_ACCESS:
      return Kind::kPermission;
    case LIBUSB_ERROR_BUSY:
      return Kind::kBusy;
    case LIBUSB_ERROR_NO_DEVICE:
    case LIBUSB_ERROR_NOT_FOUND:
      return Kind::kNotFound;
    default:
      return Kind::kFault;
  }
}

const char* remedy_for(Kind kind) {
  switch (kind) {
    case Kind::kPermission:
      return "install the udev rules of this program, and be in group plugdev";
    case Kind::kBusy:
      return "end the other program that uses it";
    default:
      return "unplug it and plug it in again";
  }
}

std::string trouble(int error) {
  return fmt::format("{}; {}", libusb_strerror(static_cast<libusb_error>(error)),
                     remedy_for(kind_of_error(error)));
}

/// None: it does not answer.
std::optional<std::string> text_of(libusb_device_handle* handle, std::uint8_t index) {
  constexpr std::uint16_t kEnglish = 0x0409;
  constexpr unsigned kPatienceMs = 100;  // much less than libusb's own
  std::array<unsigned char, 255> bytes{};
  if (index == 0) return "";
  const int n =
      libusb_control_transfer(handle, LIBUSB_ENDPOINT_IN, LIBUSB_REQUEST_GET_DESCRIPTOR,
                              static_cast<std::uint16_t>(LIBUSB_DT_STRING << 8 | index), kEnglish,
                              bytes.data(), static_cast<std::uint16_t>(bytes.size()), kPatienceMs);
  if (n == LIBUSB_ERROR_TIMEOUT) return std::nullopt;
  return n < 0 ? std::string() : usb_text({bytes.data(), static_cast<std::size_t>(n)});
}

void read_texts(libusb_device_handle* handle, const libusb_device_descriptor& d, UsbFound& found) {
  for (const auto& [text, index] :
       {std::pair{&found.serial, d.iSerialNumber}, std::pair{&found.model, d.iProduct},
        std::pair{&found.manufacturer, d.iManufacturer}}) {
    const auto answer = text_of(handle, index);
    if (!answer) return;
    *text = *answer;
  }
}

struct Opened {
  UsbFound found;
  Handle handle;  // none: it cannot be opened, for this
  Kind error{};
};

std::vector<Opened> open_all(libusb_context* context, std::uint16_t vendor, std::uint16_t product) {
  std::vector<Opened> out;
  libusb_device** list = nullptr;
  const auto count = libusb_get_device_list(context, &list);
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    libusb_device_descriptor d{};
    if (libusb_get_device_descriptor(list[i], &d) || d.idVendor != vendor || d.idProduct != product)
      continue;
    Opened one;
    one.found.address = fmt::format("usb {}:{}", libusb_get_bus_number(list[i]),
                                    libusb_get_device_address(list[i]));
    one.found.version = d.bcdDevice;
    libusb_device_handle* handle = nullptr;
    if (const int r = libusb_open(list[i], &handle)) {
      one.error = kind_of_error(r);
      one.found.trouble = trouble(r);
    } else {
      one.handle.reset(handle);
      read_texts(handle, d, one.found);
    }
    out.push_back(std::move(one));
  }
  if (count >= 0) libusb_free_device_list(list, 1);
  return out;
}

void LIBUSB_CALL set_completed(libusb_transfer* transfer) {
  *static_cast<int*>(transfer->user_data) = 1;
}

}  // namespace

std::string usb_text(std::span<const std::uint8_t> descriptor) {
  std::string out;
  for (std::size_t i = 2; i + 1 < std::min<std::size_t>(descriptor.size(), descriptor[0]); i += 2) {
    const bool printable = descriptor[i + 1] == 0 && descriptor[i] >= 0x20 && descriptor[i] < 0x7f;
    out += printable ? static_cast<char>(descriptor[i]) : '?';
  }
  return out;
}

std::vector<UsbFound> list_usb_devices(std::uint16_t vendor, std::uint16_t product) {
  const Context context = new_context();
  std::vector<UsbFound> out;
  for (Opened& d : open_all(context.get(), vendor, product)) {
    if (d.handle) {
      const int r = libusb_claim_interface(d.handle.get(), 0);
      if (r) d.found.trouble = trouble(r);
    }
    out.push_back(std::move(d.found));
  }
  return out;
}

struct UsbDevice::Impl {
  explicit Impl(std::string name) : what(std::move(name)) {}
  ~Impl();

  static int LIBUSB_CALL on_left(libusb_context*, libusb_device* device, libusb_hotplug_event,
                                 void* self) {
    auto& impl = *static_cast<Impl*>(self);
    if (impl.handle && device == libusb_get_device(impl.handle.get())) impl.lost = true;
    return 0;
  }

  [[noreturn]] void fail_lost() {
    lost = true;
    throw DeviceError(Kind::kDisconnected, what + " is no longer there",
                      "plug it in and open it again");
  }
  void require_connected();
  void run(libusb_transfer*, const Deadline&);
  std::size_t bulk(std::uint8_t endpoint, std::span<std::uint8_t>, const Deadline&);

  const std::string what;
  Context context = new_context();
  Handle handle;
  int interface = 0;
  UsbFound about;
  libusb_hotplug_callback_handle left_callback = 0;
  std::atomic<bool> lost = false;

  std::mutex mutex;  // of the next two
  libusb_transfer* in_flight = nullptr;
  bool aborted = false;

  std::mutex at_once_mutex;
  Transfer at_once = new_transfer();
};

UsbDevice::Impl::~Impl() {
  if (handle) {
    libusb_hotplug_deregister_callback(context.get(), left_callback);
    libusb_release_interface(handle.get(), interface);
  }
}

void UsbDevice::Impl::require_connected() {
  timeval none{0, 0};
  libusb_handle_events_timeout_completed(context.get(), &none, nullptr);  // it may have left
  if (lost) fail_lost();
}

/// Submits the transfer and waits for its end, whatever that is.
void UsbDevice::Impl::run(libusb_transfer* transfer, const Deadline& deadline) {
  const SteadyClock clock;
  int completed = 0;
  transfer->callback = set_completed;
  transfer->user_data = &completed;
  const auto fail_if_due = [&] {
    if (deadline.cancel.stop_requested()) throw Cancelled(what + ": stopped on request");
    if (clock.now_ns() >= deadline.at_ns)
      throw DeviceError(Kind::kTimeout, what + " does not answer",
                        "unplug it and plug it in again");
  };
  fail_if_due();
  {
    const std::lock_guard lock(mutex);
    aborted = false;
    if (const int r = libusb_submit_transfer(transfer)) {
      if (r == LIBUSB_ERROR_NO_DEVICE) fail_lost();
      throw DeviceError(Kind::kFault,
                        fmt::format("{} takes no transfer ({})", what, libusb_error_name(r)),
                        "unplug it and plug it in again");
    }
    in_flight = transfer;
  }
  bool cancelled = false;
  while (!completed) {
    const Nanoseconds left = deadline.at_ns - clock.now_ns();
    if (!cancelled && (left <= 0 || deadline.cancel.stop_requested())) {
      libusb_cancel_transfer(transfer);
      cancelled = true;
    }
    const Nanoseconds slice =
        cancelled ? kStopCheckNs : std::clamp<Nanoseconds>(left, 0, kStopCheckNs);
    timeval nap{0, static_cast<long>(slice / 1000)};
    libusb_handle_events_timeout_completed(context.get(), &nap, &completed);
  }
  bool broken_off = false;
  {
    const std::lock_guard lock(mutex);
    in_flight = nullptr;
    broken_off = aborted;
  }
  if (transfer->status == LIBUSB_TRANSFER_COMPLETED || transfer->status == LIBUSB_TRANSFER_STALL)
    return;
  if (transfer->status == LIBUSB_TRANSFER_NO_DEVICE) fail_lost();
  if (transfer->status == LIBUSB_TRANSFER_CANCELLED) {
    if (broken_off)
      throw DeviceError(Kind::kRefused, what + " was told to stop meanwhile", "ask it again");
    fail_if_due();
  }
  // The kernel may report the loss of a device as an error of the bus first.
  require_connected();
  throw DeviceError(Kind::kFault, "the USB bus fails in a transfer of " + what,
                    "check the cable, and use a port of the machine itself");
}

std::size_t UsbDevice::Impl::bulk(std::uint8_t endpoint, std::span<std::uint8_t> bytes,
                                  const Deadline& deadline) {
  require_connected();
  const Transfer transfer = new_transfer();
  for (int attempt = 0; attempt < 2; ++attempt) {
    libusb_fill_bulk_transfer(transfer.get(), handle.get(), endpoint, bytes.data(),
                              static_cast<int>(bytes.size()), nullptr, nullptr, 0);
    run(transfer.get(), deadline);
    if (transfer->status == LIBUSB_TRANSFER_COMPLETED)
      return static_cast<std::size_t>(transfer->actual_length);
    if (libusb_clear_halt(handle.get(), endpoint) == LIBUSB_ERROR_NO_DEVICE) fail_lost();
  }
  throw DeviceError(Kind::kFault, fmt::format("{} stalls again and again", what),
                    "unplug it and plug it in again");
}

UsbDevice::UsbDevice(const std::string& what, const UsbIdentity& wanted, int interface)
    : impl_(std::make_unique<Impl>(what)) {
  std::vector<Opened> all = open_all(impl_->context.get(), wanted.vendor, wanted.product);
  const auto closed =
      std::find_if(all.begin(), all.end(), [](const Opened& d) { return !d.handle; });
  if (closed != all.end() && (wanted.serial.empty() || all.size() == 1))
    throw DeviceError(closed->error,
                      fmt::format("{} ({}) cannot be opened", what, closed->found.address),
                      remedy_for(closed->error));
  std::erase_if(all, [&](const Opened& d) {
    return !d.handle || (!wanted.serial.empty() && d.found.serial != wanted.serial);
  });
  const std::string which = fmt::format("usb {:04x}:{:04x}{}", wanted.vendor, wanted.product,
                                        wanted.serial.empty() ? "" : ", serial " + wanted.serial);
  if (all.empty())
    throw DeviceError(Kind::kNotFound, fmt::format("{} is not there ({})", what, which),
                      "plug it in, or correct its serial in the rig file");
  if (all.size() > 1)
    throw DeviceError(Kind::kNotFound, fmt::format("several devices could be {} ({})", what, which),
                      "name the serial of the right one in the rig file, or unplug the others");
  if (const int r = libusb_claim_interface(all[0].handle.get(), interface)) {
    const Kind kind = kind_of_error(r);
    throw DeviceError(kind, fmt::format("{} ({}) is in use", what, libusb_error_name(r)),
                      remedy_for(kind));
  }
  impl_->handle = std::move(all[0].handle);
  impl_->about = std::move(all[0].found);
  impl_->interface = interface;
  libusb_hotplug_register_callback(impl_->context.get(), LIBUSB_HOTPLUG_EVENT_DEVICE_LEFT, 0,
                                   wanted.vendor, wanted.product, LIBUSB_HOTPLUG_MATCH_ANY,
                                   Impl::on_left, impl_.get(), &impl_->left_callback);
}

UsbDevice::~UsbDevice() = default;

const UsbFound& UsbDevice::about() const {
  return impl_->about;
}

void UsbDevice::write(std::uint8_t endpoint, std::span<const std::uint8_t> bytes,
                      const Deadline& deadline) {
  std::vector<std::uint8_t> copy(bytes.begin(), bytes.end());
  if (impl_->bulk(endpoint, copy, deadline) != bytes.size())
    throw DeviceError(Kind::kFault, impl_->what + " took a part of what was sent", "send it again");
}

std::vector<std::uint8_t> UsbDevice::read(std::uint8_t endpoint, std::size_t longest,
                                          const Deadline& deadline) {
  std::vector<std::uint8_t> bytes(longest);
  bytes.resize(impl_->bulk(endpoint, bytes, deadline));
  return bytes;
}

std::optional<std::vector<std::uint8_t>> UsbDevice::ask(const UsbRequest& request,
                                                        std::uint16_t longest,
                                                        const Deadline& deadline) {
  impl_->require_connected();
  std::vector<std::uint8_t> bytes(LIBUSB_CONTROL_SETUP_SIZE + longest);
  libusb_fill_control_setup(bytes.data(), request.type, request.request, request.value,
                            request.index, longest);
  const Transfer transfer = new_transfer();
  libusb_fill_control_transfer(transfer.get(), impl_->handle.get(), bytes.data(), nullptr, nullptr,
                               0);
  impl_->run(transfer.get(), deadline);
  if (transfer->status == LIBUSB_TRANSFER_STALL) return std::nullopt;
  return std::vector<std::uint8_t>(
      bytes.begin() + LIBUSB_CONTROL_SETUP_SIZE,
      bytes.begin() + LIBUSB_CONTROL_SETUP_SIZE + transfer->actual_length);
}

void UsbDevice::abort() noexcept {
  const std::lock_guard lock(impl_->mutex);
  if (!impl_->in_flight) return;
  impl_->aborted = true;
  libusb_cancel_transfer(impl_->in_flight);
}

void UsbDevice::write_at_once(std::uint8_t endpoint, std::span<const std::uint8_t> bytes) noexcept {
  if (impl_->lost) return;
  const std::lock_guard lock(impl_->at_once_mutex);
  const SteadyClock clock;
  const Nanoseconds end = clock.now_ns() + kAtOnceNs;
  libusb_transfer* transfer = impl_->at_once.get();
  for (int attempt = 0; attempt < 2; ++attempt) {
    int completed = 0;
    // libusb only reads what goes to the device.
    libusb_fill_bulk_transfer(transfer, impl_->handle.get(), endpoint,
                              const_cast<unsigned char*>(bytes.data()),
                              static_cast<int>(bytes.size()), set_completed, &completed, 0);
    if (libusb_submit_transfer(transfer)) return;
    for (bool cancelled = false; !completed;) {
      const Nanoseconds left = end - clock.now_ns();
      if (left <= 0 && !std::exchange(cancelled, true)) libusb_cancel_transfer(transfer);
      timeval nap{0, static_cast<long>(std::clamp<Nanoseconds>(left, 1'000'000, kAtOnceNs) / 1000)};
      libusb_handle_events_timeout_completed(impl_->context.get(), &nap, &completed);
    }
    if (transfer->status != LIBUSB_TRANSFER_STALL) return;
    libusb_clear_halt(impl_->handle.get(), endpoint);
  }
}

}  // namespace wheatstone
