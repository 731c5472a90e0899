#include "sim/wire/usb/usb_node.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <utility>

#include "hardware/device_error.h"

namespace wheatstone {
namespace {

namespace fs = std::filesystem;

std::string hex(const std::vector<std::uint8_t>& bytes) {
  std::string out;
  for (const std::uint8_t b : bytes) out += fmt::format("{:02X}", b);
  return out;
}

/// umockdev takes only text.
std::string printable(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c > 0x7e; }, '?');
  return text;
}

/// As umockdev reads a device.
std::string device_entry(const UsbDescription& d, const std::string& device, unsigned address,
                         const std::string& port) {
  const std::string descriptors = hex(d.device_descriptor()) + hex(d.configuration_descriptor());
  std::string text = fmt::format(
      "P: {}\nN: bus/usb/001/{:03}={}\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\n"
      "E: DEVNAME=/dev/bus/usb/001/{:03}\nE: BUSNUM=001\nE: DEVNUM={:03}\nE: MAJOR=189\n"
      "E: MINOR={}\nE: PRODUCT={:x}/{:x}/{:x}\nE: ID_VENDOR_ID={:04x}\nE: ID_MODEL_ID={:04x}\n"
      "A: busnum=1\\n\nA: devnum={}\\n\nA: devpath={}\\n\nA: speed={}\\n\n"
      "A: bConfigurationValue=1\\n\nA: bNumConfigurations=1\\n\nA: bDeviceClass=00\\n\n"
      "A: bNumInterfaces={:2}\\n\nA: idVendor={:04x}\\n\nA: idProduct={:04x}\\n\n"
      "A: bcdDevice={:04x}\\n\nA: dev=189:{}\\n\nH: descriptors={}\n",
      device, address, descriptors, address, address, address - 1, d.vendor, d.product, d.version,
      d.vendor, d.product, address, port, d.high_speed ? 480 : 12, d.interfaces.size(), d.vendor,
      d.product, d.version, address - 1, descriptors);
  const std::pair<const char*, std::string> strings[] = {
      {"manufacturer", d.manufacturer}, {"product", d.model}, {"serial", d.serial}};
  for (const auto& [name, value] : strings)
    if (!value.empty()) text += fmt::format("A: {}={}\\n\n", name, printable(value));
  return text + "\n";
}

std::string interface_entry(const UsbInterface& f, std::size_t number, const std::string& device) {
  return fmt::format(
      "P: {}\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_interface\n"
      "E: INTERFACE={}/{}/{}\nA: bInterfaceNumber={:02x}\\n\nA: bInterfaceClass={:02x}\\n\n"
      "A: bInterfaceSubClass={:02x}\\n\nA: bInterfaceProtocol={:02x}\\n\n\n",
      device, f.device_class, f.subclass, f.protocol, number, f.device_class, f.subclass,
      f.protocol);
}

/// The pipe in place of the node. libusb waits until a node can be written, which for a plain file
/// is always; a full pipe cannot, until something is taken out of it.
int make_pipe(const fs::path& node) {
  fs::remove(node);
  int handle = -1;
  if (::mkfifo(node.c_str(), 0666) == 0)
    handle = ::open(node.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (handle < 0)
    throw DeviceError(DeviceError::Kind::kFault, "no pipe can be made for an emulated USB device",
                      "check the room in the temporary folder");
  ::fcntl(handle, F_SETPIPE_SZ, 4096);
  return handle;
}

}  // namespace

UsbNode::UsbNode(MockBed& bed, const UsbDescription& description, unsigned address,
                 const std::string& port)
    : bed_(bed), path_(fmt::format("/dev/bus/usb/001/{:03}", address)) {
  const std::string name = "1-" + port, device = "/devices/pci0000:00/0000:00:14.0/usb1/" + name;
  std::string text = device_entry(description, device, address, port);
  for (std::size_t i = 0; i < description.interfaces.size(); ++i) {
    const std::string interface = fmt::format("{}/{}:1.{}", device, name, i);
    text += interface_entry(description.interfaces[i], i, interface);
    interfaces_.push_back("/sys" + interface);
  }
  device_ = "/sys" + device;
  bed_.add(text);
  pipe_ = make_pipe(bed_.real_path(path_));
  quiet();
}

UsbNode::~UsbNode() {
  ::close(pipe_);
}

void UsbNode::announce() {
  bed_.announce(device_, "add");
}

void UsbNode::take_away() {
  std::vector<std::string> gone = interfaces_;
  gone.push_back(device_);
  bed_.announce(device_, "remove");
  bed_.remove(gone);
}

void UsbNode::ring() const {
  std::array<char, 4096> bytes;
  while (::read(pipe_, bytes.data(), bytes.size()) > 0) {
  }
}

void UsbNode::quiet() const {
  constexpr std::array<char, 4096> kBytes{};
  while (::write(pipe_, kBytes.data(), kBytes.size()) > 0) {
  }
}

}  // namespace wheatstone
