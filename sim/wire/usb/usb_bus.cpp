#include "sim/wire/usb/usb_bus.h"

#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <cstddef>
#include <cstring>
#include <list>
#include <map>
#include <mutex>
#include <set>
#include <thread>
#include <utility>

#include "sim/wire/usb/usb_node.h"

namespace wheatstone {
namespace {

using End = UsbReply::End;

constexpr std::uint32_t kCapabilities =
    USBDEVFS_CAP_ZERO_PACKET | USBDEVFS_CAP_NO_PACKET_SIZE_LIM | USBDEVFS_CAP_REAP_AFTER_DISCONNECT;
constexpr std::size_t kSetupBytes = 8;
constexpr std::size_t kLongestTransfer = 64 << 20;
constexpr std::uint8_t kToHost = 0x80;
constexpr std::uint8_t kClearFeature = 1, kOfEndpoint = 2;

UsbSetup parse_setup(const std::uint8_t* b) {
  const auto word = [&](int at) { return static_cast<std::uint16_t>(b[at] | b[at + 1] << 8); };
  return {b[0], b[1], word(2), word(4), word(6)};
}

std::uintptr_t next_number() {
  static std::atomic<std::uintptr_t> next = 0;
  return next++;
}

struct Urb {
  UMockdevIoctlClient* client = nullptr;  // for comparison only
  OwnedGObject<UMockdevIoctlData> data, buffer;
  usbdevfs_urb& urb() const { return *reinterpret_cast<usbdevfs_urb*>(data->data); }
};

}  // namespace

struct UsbDevicePeer::Impl {
  Impl(MockBed& b, UsbFirmware& f, const std::string& port);
  ~Impl();

  /// Handlers run in umockdev's thread and may be late: they find the device by its number, or no
  /// longer.
  struct Living {
    std::mutex mutex;
    std::map<std::uintptr_t, Impl*> devices;
  };
  static Living& living() {
    static Living all;
    return all;
  }
  static gboolean on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer number) {
    const std::lock_guard lock(living().mutex);
    const auto it = living().devices.find(reinterpret_cast<std::uintptr_t>(number));
    if (it == living().devices.end())
      umockdev_ioctl_client_complete(client, -1, ENODEV);
    else
      it->second->ioctl(client);
    return TRUE;
  }
  static void on_client_gone(gpointer number, GObject* client) {
    const std::lock_guard lock(living().mutex);
    const auto it = living().devices.find(reinterpret_cast<std::uintptr_t>(number));
    if (it != living().devices.end())
      it->second->forget(reinterpret_cast<UMockdevIoctlClient*>(client));
  }

  void ioctl(UMockdevIoctlClient*);
  void forget(UMockdevIoctlClient*);
  int answer(UMockdevIoctlClient*, unsigned long request, UMockdevIoctlData*);
  int claim(UMockdevIoctlClient*, std::uint32_t interface);
  int submit(UMockdevIoctlClient*, UMockdevIoctlData*);
  int reap(UMockdevIoctlClient*, UMockdevIoctlData*);
  int discard(UMockdevIoctlClient*, unsigned long address);
  void clear_halt(std::uint8_t endpoint);

  void try_pending();
  UsbReply carry_out(const Urb&, Nanoseconds now);
  void finish(std::list<Urb>::iterator, int status, std::size_t bytes);
  void pull_out();
  void take_away();
  void serve(const std::stop_token&);

  MockBed& bed;
  UsbFirmware& firmware;
  const UsbDescription description;
  const std::uintptr_t number;
  UsbNode node;
  OwnedGObject<UMockdevIoctlBase> handler;

  std::mutex removal;  // before the next one
  std::mutex mutex;    // of all below and of the firmware
  std::condition_variable_any changed;
  std::set<UMockdevIoctlClient*> clients;
  std::map<std::uint32_t, UMockdevIoctlClient*> claims;  // by interface
  std::set<std::uint8_t> halted;
  std::list<Urb> pending, finished;
  bool unplugged = false, taken_away = false;
  int claim_error = 0;
  std::jthread worker;
};

UsbDevicePeer::Impl::Impl(MockBed& b, UsbFirmware& f, const std::string& port)
    : bed(b),
      firmware(f),
      description(f.description()),
      number(next_number()),
      node(b, description, static_cast<unsigned>(2 + number % 126), port),
      handler(umockdev_ioctl_base_new()) {
  g_signal_connect(handler.get(), "handle-ioctl", G_CALLBACK(on_ioctl),
                   reinterpret_cast<gpointer>(number));
  bed.attach(node.path(), handler.get());
  {
    const std::lock_guard lock(living().mutex);
    living().devices[number] = this;
  }
  node.announce();
  worker = std::jthread([this](const std::stop_token& s) { serve(s); });
}

UsbDevicePeer::Impl::~Impl() {
  {
    const std::lock_guard lock(mutex);
    pull_out();
  }
  take_away();
  worker.request_stop();
  worker.join();
  bed.detach(node.path());
  const std::lock_guard lock(living().mutex);
  living().devices.erase(number);
}

void UsbDevicePeer::Impl::ioctl(UMockdevIoctlClient* client) {
  const std::lock_guard lock(mutex);
  if (clients.insert(client).second)
    g_object_weak_ref(G_OBJECT(client), on_client_gone, reinterpret_cast<gpointer>(number));
  // The client's int is 32 bits; the preloaded ioctl() may extend its sign.
  const unsigned long request = umockdev_ioctl_client_get_request(client) & 0xffffffffUL;
  UMockdevIoctlData* argument = umockdev_ioctl_client_get_arg(client);
  int error = 0;
  if (request == USBDEVFS_DISCARDURB) {
    unsigned long address = 0;
    std::memcpy(&address, argument->data, sizeof address);
    error = discard(client, address);
  } else if (_IOC_SIZE(request) == 0) {
    error = answer(client, request, nullptr);
  } else {
    const OwnedGObject<UMockdevIoctlData> data(
        umockdev_ioctl_data_resolve(argument, 0, _IOC_SIZE(request), nullptr));
    error = data ? answer(client, request, data.get()) : EFAULT;
  }
  umockdev_ioctl_client_complete(client, error ? -1 : 0, error);
}

int UsbDevicePeer::Impl::answer(UMockdevIoctlClient* client, unsigned long request,
                                UMockdevIoctlData* data) {
  if (request == USBDEVFS_REAPURB || request == USBDEVFS_REAPURBNDELAY) return reap(client, data);
  if (unplugged) return ENODEV;
  const auto word = [&] {
    std::uint32_t n = 0;
    std::memcpy(&n, data->data, sizeof n);
    return n;
  };
  switch (request) {
    case USBDEVFS_GET_CAPABILITIES:
      std::memcpy(data->data, &kCapabilities, sizeof kCapabilities);
      return 0;
    case USBDEVFS_CLAIMINTERFACE:
      return claim(client, word());
    case USBDEVFS_RELEASEINTERFACE: {
      const auto it = claims.find(word());
      if (it == claims.end() || it->second != client) return EINVAL;
      claims.erase(it);
      return 0;
    }
    case USBDEVFS_SETINTERFACE:
    case USBDEVFS_SETCONFIGURATION:
      return 0;
    case USBDEVFS_GETDRIVER:
    case USBDEVFS_IOCTL:  // to take an interface from the kernel's driver
      return ENODATA;
    case USBDEVFS_CLEAR_HALT:
      clear_halt(static_cast<std::uint8_t>(word()));
      return 0;
    case USBDEVFS_RESET:
      halted.clear();
      firmware.reset();
      return 0;
    case USBDEVFS_SUBMITURB:
      return submit(client, data);
    default:
      return ENOTTY;
  }
}

int UsbDevicePeer::Impl::claim(UMockdevIoctlClient* client, std::uint32_t interface) {
  if (claim_error) return claim_error;
  if (interface >= description.interfaces.size()) return ENOENT;
  return claims.try_emplace(interface, client).first->second == client ? 0 : EBUSY;
}

void UsbDevicePeer::Impl::clear_halt(std::uint8_t endpoint) {
  halted.erase(endpoint);
  firmware.halt_cleared(endpoint);
}

int UsbDevicePeer::Impl::submit(UMockdevIoctlClient* client, UMockdevIoctlData* data) {
  usbdevfs_urb& urb = *reinterpret_cast<usbdevfs_urb*>(data->data);
  if (urb.type == USBDEVFS_URB_TYPE_ISO || urb.buffer_length < 0 ||
      static_cast<std::size_t>(urb.buffer_length) > kLongestTransfer)
    return EINVAL;
  if (urb.type == USBDEVFS_URB_TYPE_CONTROL) {
    if (static_cast<std::size_t>(urb.buffer_length) < kSetupBytes) return EINVAL;
  } else {
    const auto has = [&](const UsbInterface& f) {
      return std::any_of(f.endpoints.begin(), f.endpoints.end(),
                         [&](const UsbEndpoint& e) { return e.address == urb.endpoint; });
    };
    const auto f = std::find_if(description.interfaces.begin(), description.interfaces.end(), has);
    if (f == description.interfaces.end()) return ENOENT;
    const auto owner = claims.find(static_cast<std::uint32_t>(f - description.interfaces.begin()));
    if (owner != claims.end() && owner->second != client) return EBUSY;
  }
  Urb kept;
  kept.client = client;
  kept.data.reset(static_cast<UMockdevIoctlData*>(g_object_ref(data)));
  if (urb.buffer_length > 0) {
    kept.buffer.reset(umockdev_ioctl_data_resolve(data, offsetof(usbdevfs_urb, buffer),
                                                  static_cast<gsize>(urb.buffer_length), nullptr));
    if (!kept.buffer) return EFAULT;
  }
  pending.push_back(std::move(kept));
  try_pending();
  changed.notify_all();
  return 0;
}

int UsbDevicePeer::Impl::reap(UMockdevIoctlClient* client, UMockdevIoctlData* data) {
  const auto it = std::find_if(finished.begin(), finished.end(),
                               [&](const Urb& u) { return u.client == client; });
  if (it == finished.end()) {
    node.quiet();
    return unplugged ? ENODEV : EAGAIN;
  }
  umockdev_ioctl_data_set_ptr(data, 0, it->data.get());
  finished.erase(it);
  if (finished.empty()) node.quiet();
  return 0;
}

int UsbDevicePeer::Impl::discard(UMockdevIoctlClient* client, unsigned long address) {
  const auto it = std::find_if(pending.begin(), pending.end(), [&](const Urb& u) {
    return u.client == client && u.data->client_addr == address;
  });
  if (it == pending.end()) return EINVAL;
  finish(it, -ENOENT, 0);
  return 0;
}

void UsbDevicePeer::Impl::forget(UMockdevIoctlClient* client) {
  const std::lock_guard lock(mutex);
  clients.erase(client);
  std::erase_if(claims, [&](const auto& c) { return c.second == client; });
  for (std::list<Urb>* urbs : {&pending, &finished})
    urbs->remove_if([&](const Urb& u) { return u.client == client; });
  if (finished.empty()) node.quiet();
}

UsbReply UsbDevicePeer::Impl::carry_out(const Urb& u, Nanoseconds now) {
  const usbdevfs_urb& urb = u.urb();
  std::uint8_t* bytes = u.buffer ? u.buffer->data : nullptr;
  const auto n = static_cast<std::size_t>(urb.buffer_length);
  if (urb.type == USBDEVFS_URB_TYPE_CONTROL) {
    UsbSetup setup = parse_setup(bytes);
    setup.length = static_cast<std::uint16_t>(std::min<std::size_t>(setup.length, n - kSetupBytes));
    if (setup.request_type == kOfEndpoint && setup.request == kClearFeature && setup.value == 0) {
      clear_halt(static_cast<std::uint8_t>(setup.index));
      return {};
    }
    const std::size_t data = setup.to_host() ? 0 : setup.length;
    return firmware.control(setup, {bytes + kSetupBytes, data}, now);
  }
  if (halted.contains(urb.endpoint)) return {End::kStall, {}};
  UsbReply reply = urb.endpoint & kToHost ? firmware.send(urb.endpoint, n, now)
                                          : firmware.receive(urb.endpoint, {bytes, n}, now);
  if (reply.end == End::kStall) halted.insert(urb.endpoint);
  return reply;
}

/// Each endpoint's transfers in their order. What one does may be what another waits for.
void UsbDevicePeer::Impl::try_pending() {
  for (bool progress = true; progress && !unplugged;) {
    progress = false;
    std::set<std::uint8_t> waiting;
    for (auto it = pending.begin(); it != pending.end() && !unplugged;) {
      const auto here = it++;
      usbdevfs_urb& urb = here->urb();
      const bool control = urb.type == USBDEVFS_URB_TYPE_CONTROL;
      const std::uint8_t endpoint = control ? 0 : urb.endpoint;
      if (waiting.contains(endpoint)) continue;
      const UsbReply reply = carry_out(*here, SteadyClock().now_ns());
      if (reply.end == End::kNothingYet) {
        waiting.insert(endpoint);
        continue;
      }
      progress = true;
      if (reply.end == End::kUnplugged) {
        pull_out();
        return;
      }
      const std::size_t head = control ? kSetupBytes : 0;
      const bool to_host = control ? here->buffer->data[0] & kToHost : urb.endpoint & kToHost;
      std::size_t bytes = static_cast<std::size_t>(urb.buffer_length) - head;
      if (to_host) {
        const std::size_t room = bytes;
        bytes = std::min(room, reply.bytes.size());
        if (bytes) std::memcpy(here->buffer->data + head, reply.bytes.data(), bytes);
      }
      const int status = reply.end == End::kStall ? -EPIPE : reply.end == End::kError ? -EPROTO : 0;
      finish(here, status, status ? 0 : bytes);
    }
  }
}

void UsbDevicePeer::Impl::finish(std::list<Urb>::iterator it, int status, std::size_t bytes) {
  it->urb().status = status;
  it->urb().actual_length = static_cast<int>(bytes);
  finished.splice(finished.end(), pending, it);
  node.ring();
}

/// The wire is cut; the machine notices a little later (take_away).
void UsbDevicePeer::Impl::pull_out() {
  unplugged = true;
  while (!pending.empty()) finish(pending.begin(), -ENODEV, 0);
  changed.notify_all();
}

void UsbDevicePeer::Impl::take_away() {
  const std::lock_guard whole(removal);  // whoever comes second waits until it is done
  {
    const std::lock_guard lock(mutex);
    if (std::exchange(taken_away, true)) return;
  }
  node.take_away();
}

void UsbDevicePeer::Impl::serve(const std::stop_token& stop) {
  std::unique_lock lock(mutex);
  while (!stop.stop_requested()) {
    if (unplugged && !taken_away) {
      lock.unlock();
      take_away();
      lock.lock();
      continue;
    }
    const Nanoseconds now = SteadyClock().now_ns();
    const Nanoseconds next = pending.empty() ? UsbFirmware::kNever : firmware.next_event();
    if (next <= now) try_pending();
    // An hour stands for ever.
    constexpr Nanoseconds kHourNs = 3'600'000'000'000;
    const auto nap =
        std::chrono::nanoseconds(next <= now ? 1'000'000 : std::min(next - now, kHourNs));
    changed.wait_for(lock, stop, nap, [&] {
      return (unplugged && !taken_away) || (!pending.empty() && firmware.next_event() < next);
    });
  }
}

UsbDevicePeer::UsbDevicePeer(MockBed& bed, UsbFirmware& firmware, const std::string& port)
    : impl_(std::make_unique<Impl>(bed, firmware, port)) {}

UsbDevicePeer::~UsbDevicePeer() = default;

std::string UsbDevicePeer::node() const {
  return impl_->node.path();
}

void UsbDevicePeer::with_firmware(const std::function<void()>& act) {
  const std::lock_guard lock(impl_->mutex);
  act();
  impl_->try_pending();
  impl_->changed.notify_all();
}

void UsbDevicePeer::unplug() {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->pull_out();
  }
  impl_->take_away();
}

void UsbDevicePeer::forbid() {
  impl_->bed.forbid(impl_->node.path());
}

void UsbDevicePeer::refuse_claims(int error) {
  const std::lock_guard lock(impl_->mutex);
  impl_->claim_error = error;
}

}  // namespace wheatstone
