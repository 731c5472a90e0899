#include "sim/wire/video/v4l2_peer.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <umockdev.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <condition_variable>
#include <cstddef>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace wheatstone {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kUserPointerAt = offsetof(v4l2_buffer, m);

std::string description(const V4l2PeerOptions& o) {
  const std::string port = "1-" + std::to_string(3 + o.node.back() - '0');
  const std::string device = "/devices/pci0000:00/0000:00:14.0/usb1/" + port;
  return fmt::format(
      "P: {device}\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nA: serial={serial}\n"
      "A: idVendor=1d6b\nA: idProduct=0102\n\n"
      "P: {device}/{port}:1.0\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_interface\n\n"
      "P: {device}/{port}:1.0/video4linux/{node}\nN: {node}=00\nE: SUBSYSTEM=video4linux\n"
      "E: DEVNAME=/dev/{node}\nE: ID_SERIAL_SHORT={serial}\nA: name={name}\nA: dev=81:{minor}\n"
      "L: device=../../../{port}:1.0\n\n",
      fmt::arg("device", device), fmt::arg("port", port), fmt::arg("serial", o.usb_serial),
      fmt::arg("node", o.node), fmt::arg("name", o.name), fmt::arg("minor", o.node.back()));
}

}  // namespace

struct V4l2Peer::Impl {
  Impl(MockBed& b, VideoFirmware& f, V4l2PeerOptions o)
      : bed(b), firmware(f), options(std::move(o)), handler(umockdev_ioctl_base_new()) {}

  // A DQBUF that is answered when there is a picture.
  struct Waiting {
    OwnedGObject<UMockdevIoctlClient> client;
    OwnedGObject<UMockdevIoctlData> data;
    unsigned long request = 0;
  };

  static gboolean on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self) {
    static_cast<Impl*>(self)->ioctl(client);
    return TRUE;
  }
  static gboolean on_read(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self) {
    static_cast<Impl*>(self)->read(client);
    return TRUE;
  }

  void ioctl(UMockdevIoctlClient*);
  void read(UMockdevIoctlClient*);
  int answer(unsigned long request, UMockdevIoctlData*);
  void place_user_buffer(UMockdevIoctlData*);
  void map_buffers();
  void unmap_buffers();
  void answer_waiting(const std::stop_token&);
  fs::path file() const { return bed.real_path("/dev/" + options.node); }

  MockBed& bed;
  VideoFirmware& firmware;
  const V4l2PeerOptions options;
  OwnedGObject<UMockdevIoctlBase> handler;

  std::mutex mutex;  // of all below and of the firmware
  std::condition_variable_any changed;
  bool unplugged = false;
  void* mapped = nullptr;
  std::size_t mapped_bytes = 0;
  std::map<std::uint32_t, OwnedGObject<UMockdevIoctlData>> user_buffers;
  std::optional<Waiting> waiting;
  std::jthread waiter;
};

void V4l2Peer::Impl::map_buffers() {
  unmap_buffers();
  if (firmware.buffer_count() == 0 || firmware.buffer_memory() != V4L2_MEMORY_MMAP) return;
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  const std::size_t each = (firmware.buffer_bytes() + page - 1) / page * page;
  mapped_bytes = each * firmware.buffer_count();
  // What the client maps is this file, as umockdev does not see mmap().
  const int handle = ::open(file().c_str(), O_RDWR | O_CLOEXEC);
  if (handle < 0) return;
  if (::ftruncate(handle, static_cast<off_t>(mapped_bytes)) == 0)
    mapped = ::mmap(nullptr, mapped_bytes, PROT_READ | PROT_WRITE, MAP_SHARED, handle, 0);
  ::close(handle);
  if (mapped == MAP_FAILED) mapped = nullptr;
  for (std::uint32_t i = 0; mapped && i < firmware.buffer_count(); ++i)
    firmware.place_buffer(i,
                          {static_cast<std::uint8_t*>(mapped) + i * each, firmware.buffer_bytes()});
}

void V4l2Peer::Impl::unmap_buffers() {
  user_buffers.clear();
  if (mapped) ::munmap(std::exchange(mapped, nullptr), mapped_bytes);
}

void V4l2Peer::Impl::place_user_buffer(UMockdevIoctlData* data) {
  const v4l2_buffer b = *reinterpret_cast<const v4l2_buffer*>(data->data);
  UMockdevIoctlData* memory = umockdev_ioctl_data_resolve(data, kUserPointerAt, b.length, nullptr);
  if (!memory) return;
  user_buffers[b.index].reset(memory);
  firmware.place_buffer(b.index, {memory->data, b.length});
}

int V4l2Peer::Impl::answer(unsigned long request, UMockdevIoctlData* data) {
  if (unplugged) return ENODEV;
  const int error = firmware.ioctl(request, data->data, SteadyClock().now_ns());
  if (error) return error;
  if (request == VIDIOC_REQBUFS) map_buffers();
  if (firmware.buffer_memory() == V4L2_MEMORY_USERPTR) {
    if (request == VIDIOC_QBUF) place_user_buffer(data);
    if (request == VIDIOC_DQBUF) {
      const auto it = user_buffers.find(reinterpret_cast<v4l2_buffer*>(data->data)->index);
      if (it != user_buffers.end())
        umockdev_ioctl_data_set_ptr(data, kUserPointerAt, it->second.get());
    }
  }
  return 0;
}

void V4l2Peer::Impl::ioctl(UMockdevIoctlClient* client) {
  const std::lock_guard lock(mutex);
  // The client's int is 32 bits; the preloaded ioctl() may extend its sign.
  const unsigned long request = umockdev_ioctl_client_get_request(client) & 0xffffffffUL;
  OwnedGObject<UMockdevIoctlData> data(umockdev_ioctl_data_resolve(
      umockdev_ioctl_client_get_arg(client), 0, _IOC_SIZE(request), nullptr));
  if (!data) {
    umockdev_ioctl_client_complete(client, -1, EFAULT);
    return;
  }
  const int error = answer(request, data.get());
  if (error == EAGAIN && request == VIDIOC_DQBUF && options.waits && firmware.streaming()) {
    g_object_ref(client);
    waiting = Waiting{OwnedGObject<UMockdevIoctlClient>(client), std::move(data), request};
    changed.notify_all();
    return;
  }
  umockdev_ioctl_client_complete(client, error ? -1 : 0, error);
}

void V4l2Peer::Impl::read(UMockdevIoctlClient* client) {
  const std::lock_guard lock(mutex);
  UMockdevIoctlData* out = umockdev_ioctl_client_get_arg(client);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(out->data_len));
  const int n = unplugged ? -ENODEV : firmware.read(bytes, SteadyClock().now_ns());
  if (n > 0) umockdev_ioctl_data_update(out, 0, bytes.data(), n);
  umockdev_ioctl_client_complete(client, n < 0 ? -1 : n, n < 0 ? -n : 0);
}

void V4l2Peer::Impl::answer_waiting(const std::stop_token& stop) {
  constexpr Nanoseconds kLongestNapNs = 20'000'000;
  std::unique_lock lock(mutex);
  while (changed.wait(lock, stop, [&] { return waiting.has_value(); })) {
    const SteadyClock clock;
    const Nanoseconds left = firmware.next_picture_ns() - clock.now_ns();
    lock.unlock();
    SteadyClock().wait_until(clock.now_ns() + std::clamp<Nanoseconds>(left, 0, kLongestNapNs));
    lock.lock();
    const int error = answer(waiting->request, waiting->data.get());
    if (error == EAGAIN && !stop.stop_requested()) continue;
    umockdev_ioctl_client_complete(waiting->client.get(), error ? -1 : 0, error);
    waiting.reset();
  }
}

V4l2Peer::V4l2Peer(MockBed& bed, VideoFirmware& firmware, V4l2PeerOptions options)
    : impl_(std::make_unique<Impl>(bed, firmware, std::move(options))) {
  bed.add(description(impl_->options));
  g_signal_connect(impl_->handler.get(), "handle-ioctl", G_CALLBACK(Impl::on_ioctl), impl_.get());
  g_signal_connect(impl_->handler.get(), "handle-read", G_CALLBACK(Impl::on_read), impl_.get());
  bed.attach(node(), impl_->handler.get());
  const fs::path link = bed.real_path(by_id());
  fs::create_directories(link.parent_path());
  fs::remove(link);
  fs::create_symlink("../../" + impl_->options.node, link);
  impl_->waiter = std::jthread([this](const std::stop_token& s) { impl_->answer_waiting(s); });
}

V4l2Peer::~V4l2Peer() {
  unplug();
  impl_->waiter.request_stop();
  impl_->waiter.join();
  impl_->bed.detach(node());
  impl_->unmap_buffers();
}

fs::path V4l2Peer::node() const {
  return fs::path("/dev") / impl_->options.node;
}

fs::path V4l2Peer::by_id() const {
  return fs::path("/dev/v4l/by-id") /
         fmt::format("usb-Wheatstone_{}-video-index0", impl_->options.usb_serial);
}

void V4l2Peer::with_firmware(const std::function<void()>& act) {
  const std::lock_guard lock(impl_->mutex);
  act();
}

void V4l2Peer::unplug() {
  {
    const std::lock_guard lock(impl_->mutex);
    if (std::exchange(impl_->unplugged, true)) return;
  }
  const std::string port = "1-" + std::to_string(3 + impl_->options.node.back() - '0');
  const std::string device = "/sys/devices/pci0000:00/0000:00:14.0/usb1/" + port;
  const std::string interface = device + "/" + port + ":1.0";
  const std::string video = interface + "/video4linux/" + impl_->options.node;
  impl_->bed.announce(video, "remove");
  impl_->bed.remove({video, interface, device});
}

}  // namespace wheatstone
