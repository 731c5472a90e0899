#include "sim/wire/mock/mock_bed.h"

#include <fmt/format.h>

#include "hardware/device_error.h"

#ifdef __SANITIZE_ADDRESS__
// umockdev's library is loaded before the sanitizer's, which does no harm; leaks of other libraries
// are pardoned by names that only whole stacks show.
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() {
  return "verify_asan_link_order=0:fast_unwind_on_malloc=0";
}
#endif

namespace wheatstone {
namespace {

namespace fs = std::filesystem;
using Kind = DeviceError::Kind;

void require(bool done, GError* error, const std::string& what) {
  const std::string reason = error ? error->message : "no reason given";
  if (error) g_error_free(error);
  if (!done)
    throw DeviceError(Kind::kFault, fmt::format("{} ({})", what, reason), "update umockdev");
}

}  // namespace

MockBed::MockBed() : bed_(umockdev_testbed_new()) {
  gchar* root = umockdev_testbed_get_root_dir(bed_.get());
  root_ = root;
  g_free(root);
  // umockdev 0.17 does not tell whether its library is preloaded: look whether it redirects.
  fs::create_directories(real_path("/dev/wheatstone-mock"));
  if (!fs::exists("/dev/wheatstone-mock"))
    throw DeviceError(Kind::kNotReady, "devices cannot be emulated here",
                      "start the program by umockdev-wrapper");
}

void MockBed::add(const std::string& description) {
  GError* error = nullptr;
  const bool added = umockdev_testbed_add_from_string(bed_.get(), description.c_str(), &error);
  require(added, error, "an emulated device cannot be plugged in");
}

void MockBed::remove(const std::vector<std::string>& devices) {
  for (const std::string& d : devices) umockdev_testbed_remove_device(bed_.get(), d.c_str());
}

void MockBed::attach(const std::string& node, UMockdevIoctlBase* handler) {
  GError* error = nullptr;
  const bool attached = umockdev_testbed_attach_ioctl(bed_.get(), node.c_str(), handler, &error);
  require(attached, error, "an emulated device cannot answer");
}

void MockBed::detach(const std::string& node) {
  umockdev_testbed_detach_ioctl(bed_.get(), node.c_str(), nullptr);
}

void MockBed::forbid(const std::string& node) {
  // Others see the tree, as they see the real /dev and /sys, and may watch it: umockdev's monitors
  // are sockets in it.
  fs::permissions(root_, fs::perms(0777));
  // umockdev ends programs that do not reach the handler.
  fs::permissions(real_path("/ioctl" + node), fs::perms(0777));
  fs::permissions(real_path(node), fs::perms::none);
}

void MockBed::announce(const std::string& device, const char* action) {
  umockdev_testbed_uevent(bed_.get(), device.c_str(), action);
}

}  // namespace wheatstone
