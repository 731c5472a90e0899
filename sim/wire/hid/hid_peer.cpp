#include "sim/wire/hid/hid_peer.h"

#include <fmt/format.h>
#include <linux/hidraw.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace wheatstone {
namespace {

namespace fs = std::filesystem;

constexpr unsigned kSetFeature = 6, kGetFeature = 7;  // numbers of HIDIOCSFEATURE, HIDIOCGFEATURE

std::string upper_hex(const std::string& bytes) {
  std::string out;
  for (const char c : bytes) out += fmt::format("{:02X}", static_cast<unsigned char>(c));
  return out;
}

/// The tree that the kernel makes of it.
struct Tree {
  Tree(const HidAbout& about, int number)
      : port(fmt::format("1-{}", 1 + number)),
        usb("/devices/pci0000:00/0000:00:14.0/usb1/" + port),
        interface(fmt::format("{}/{}:1.0", usb, port)),
        hid(fmt::format("{}/0003:{:04X}:{:04X}.{:04X}", interface, about.vendor, about.product,
                        1 + number)),
        node(fmt::format("hidraw{}", number)),
        hidraw(fmt::format("{}/hidraw/{}", hid, node)) {}

  std::string description(const HidAbout& about, int number) const {
    const auto attribute = [](const char* name, const std::string& value) {
      return value.empty() ? "" : fmt::format("A: {}={}\\n\n", name, value);
    };
    return fmt::format("P: {}\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\n", usb) +
           fmt::format("A: idVendor={:04x}\\n\nA: idProduct={:04x}\\n\nA: bcdDevice=0100\\n\n",
                       about.vendor, about.product) +
           attribute("manufacturer", about.manufacturer) +
           attribute("product", about.product_name) + attribute("serial", about.serial) +
           fmt::format(
               "\nP: {}\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_interface\n"
               "A: bInterfaceNumber=00\\n\n\n",
               interface) +
           fmt::format(
               "P: {}\nE: SUBSYSTEM=hid\nE: HID_ID=0003:{:08X}:{:08X}\n"
               "E: HID_NAME={} {}\nE: HID_UNIQ={}\nH: report_descriptor={}\n\n",
               hid, about.vendor, about.product, about.manufacturer, about.product_name,
               about.serial, upper_hex(about.report_descriptor)) +
           fmt::format(
               "P: {}\nN: {}=00\nE: SUBSYSTEM=hidraw\nE: DEVNAME=/dev/{}\n"
               "A: dev=240:{}\nL: device=../../../{}\n\n",
               hidraw, node, node, number, fs::path(hid).filename().string());
  }
  /// The innermost first.
  std::vector<std::string> sys_paths() const {
    return {"/sys" + hidraw, "/sys" + hid, "/sys" + interface, "/sys" + usb};
  }

  std::string port, usb, interface, hid, node, hidraw;
};

}  // namespace

struct HidPeer::Impl {
  // A transfer that ends later.
  struct Held {
    OwnedGObject<UMockdevIoctlClient> client;
    std::function<void(int error)> end;
    Nanoseconds due_ns = 0;
    bool lost = false;  // the device never sees it
  };

  Impl(MockBed& b, HidFirmware& f, int number)
      : bed(b),
        firmware(f),
        about(f.about()),
        tree(about, number),
        handler(umockdev_ioctl_base_new()) {}

  static gboolean on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self) {
    static_cast<Impl*>(self)->ioctl(client);
    return TRUE;
  }
  static gboolean on_write(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self) {
    static_cast<Impl*>(self)->write(client);
    return TRUE;
  }

  void ioctl(UMockdevIoctlClient*);
  void write(UMockdevIoctlClient*);
  void transfer(UMockdevIoctlClient*, std::function<void(int error)> end);
  int set_report(const std::string& bytes);
  void end_held(const std::stop_token&);
  void pull_cable();

  MockBed& bed;
  HidFirmware& firmware;
  const HidAbout about;
  const Tree tree;
  OwnedGObject<UMockdevIoctlBase> handler;

  std::mutex mutex;  // of all below and of the firmware
  std::condition_variable_any changed;
  bool unplugged = false;
  Nanoseconds silence_ns = 0, delay_ns = 0;
  int transfers_left = -1;  // then the cable is pulled; -1: it is not
  std::deque<Held> held;
  std::jthread ender;
};

/// As the kernel does: number 0 is for itself and does not go over the bus.
int HidPeer::Impl::set_report(const std::string& bytes) {
  const auto number = static_cast<std::uint8_t>(bytes[0]);
  return firmware.set_report(number, number ? bytes : bytes.substr(1), SteadyClock().now_ns());
}

/// `end` carries it out and completes it, with 0, or completes it with an error.
void HidPeer::Impl::transfer(UMockdevIoctlClient* client, std::function<void(int error)> end) {
  const bool pulled = transfers_left > 0 && --transfers_left == 0;
  if (unplugged) {
    end(ENODEV);
  } else if (pulled || silence_ns || delay_ns) {
    g_object_ref(client);
    constexpr Nanoseconds kPullNs = 50'000'000;
    const Nanoseconds later = pulled ? kPullNs : silence_ns ? silence_ns : delay_ns;
    held.push_back({OwnedGObject<UMockdevIoctlClient>(client), std::move(end),
                    SteadyClock().now_ns() + later, pulled || silence_ns != 0});
    if (pulled) transfers_left = 0;
    changed.notify_all();
  } else {
    end(0);
  }
}

void HidPeer::Impl::ioctl(UMockdevIoctlClient* client) {
  const std::lock_guard lock(mutex);
  // The client's int is 32 bits; the preloaded ioctl() may extend its sign.
  const unsigned long request = umockdev_ioctl_client_get_request(client) & 0xffffffffUL;
  const auto complete = [client](long result, int error) {
    umockdev_ioctl_client_complete(client, error ? -1 : result, error);
  };
  const std::size_t size = _IOC_SIZE(request);
  const std::shared_ptr<UMockdevIoctlData> data(
      umockdev_ioctl_data_resolve(umockdev_ioctl_client_get_arg(client), 0, size, nullptr),
      UnrefGObject());
  if (_IOC_TYPE(request) != 'H' || !data || size == 0) return complete(0, ENOTTY);
  if (request == HIDIOCGRDESCSIZE) {
    const int bytes = static_cast<int>(about.report_descriptor.size());
    std::memcpy(data->data, &bytes, sizeof bytes);
    return complete(0, 0);
  }
  if (request == HIDIOCGRDESC) {
    auto* descriptor = reinterpret_cast<hidraw_report_descriptor*>(data->data);
    const std::string& own = about.report_descriptor;
    std::memcpy(descriptor->value, own.data(), std::min<std::size_t>(own.size(), descriptor->size));
    return complete(0, 0);
  }
  if (_IOC_NR(request) == kSetFeature) {
    std::string bytes(reinterpret_cast<const char*>(data->data), size);
    return transfer(client, [this, complete, bytes](int error) {
      if (!error) error = set_report(bytes);
      complete(static_cast<long>(bytes.size()), error);
    });
  }
  if (_IOC_NR(request) == kGetFeature)
    return transfer(client, [this, complete, data, size](int error) {
      std::string bytes;
      if (!error) error = firmware.get_report(data->data[0], bytes, SteadyClock().now_ns());
      const std::size_t n = std::min(bytes.size(), size);
      if (!error) std::memcpy(data->data, bytes.data(), n);
      complete(static_cast<long>(n), error);
    });
  complete(0, ENOTTY);
}

/// An output report. A device without an endpoint for them takes it as it takes feature reports.
void HidPeer::Impl::write(UMockdevIoctlClient* client) {
  const std::lock_guard lock(mutex);
  const UMockdevIoctlData* data = umockdev_ioctl_client_get_arg(client);
  std::string bytes(reinterpret_cast<const char*>(data->data),
                    static_cast<std::size_t>(data->data_len));
  if (bytes.empty()) {
    umockdev_ioctl_client_complete(client, -1, EINVAL);
    return;
  }
  transfer(client, [this, client, bytes](int error) {
    if (!error) error = set_report(bytes);
    umockdev_ioctl_client_complete(client, error ? -1 : static_cast<long>(bytes.size()), error);
  });
}

void HidPeer::Impl::end_held(const std::stop_token& stop) {
  std::unique_lock lock(mutex);
  while (changed.wait(lock, stop, [&] { return !held.empty(); }) || !held.empty()) {
    const auto at =
        std::chrono::steady_clock::time_point(std::chrono::nanoseconds(held.front().due_ns));
    changed.wait_until(lock, stop, at, [&] { return unplugged; });
    const bool pull = held.front().lost && transfers_left == 0 && !unplugged;
    if (pull) {
      unplugged = true;
      lock.unlock();
      pull_cable();
      lock.lock();
    }
    Held h = std::move(held.front());
    held.pop_front();
    h.end(unplugged ? ENODEV : h.lost ? ETIMEDOUT : 0);
  }
}

void HidPeer::Impl::pull_cable() {
  bed.announce(tree.sys_paths().front(), "remove");
  bed.remove(tree.sys_paths());
  const std::lock_guard lock(mutex);
  firmware.lose_power();
}

HidPeer::HidPeer(MockBed& bed, HidFirmware& firmware, int number)
    : impl_(std::make_unique<Impl>(bed, firmware, number)) {
  bed.add(impl_->tree.description(impl_->about, number));
  g_signal_connect(impl_->handler.get(), "handle-ioctl", G_CALLBACK(Impl::on_ioctl), impl_.get());
  g_signal_connect(impl_->handler.get(), "handle-write", G_CALLBACK(Impl::on_write), impl_.get());
  bed.attach(node(), impl_->handler.get());
  impl_->ender = std::jthread([this](const std::stop_token& s) { impl_->end_held(s); });
}

HidPeer::~HidPeer() {
  unplug();
  impl_->ender.request_stop();
  impl_->ender.join();
  impl_->bed.detach(node());
}

fs::path HidPeer::node() const {
  return fs::path("/dev") / impl_->tree.node;
}

void HidPeer::with_firmware(const std::function<void()>& act) {
  const std::lock_guard lock(impl_->mutex);
  act();
}

void HidPeer::silence(Duration kernel_gives_up) {
  const std::lock_guard lock(impl_->mutex);
  impl_->silence_ns = static_cast<Nanoseconds>(kernel_gives_up.value() * 1e9);
}

void HidPeer::delay(Duration delay) {
  const std::lock_guard lock(impl_->mutex);
  impl_->delay_ns = static_cast<Nanoseconds>(delay.value() * 1e9);
}

void HidPeer::unplug() {
  {
    const std::lock_guard lock(impl_->mutex);
    if (std::exchange(impl_->unplugged, true)) return;
    impl_->changed.notify_all();
  }
  impl_->pull_cable();
}

void HidPeer::unplug_after(int transfers) {
  const std::lock_guard lock(impl_->mutex);
  impl_->transfers_left = transfers;
}

void HidPeer::forbid() {
  impl_->bed.forbid(node().string());
}

}  // namespace wheatstone
