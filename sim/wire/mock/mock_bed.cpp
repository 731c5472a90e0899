#include "sim/wire/mock/mock_bed.h"

#include <fmt/format.h>

#include "hardware/device_error.h"

namespace wheatstone {
namespace {

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
  const char* probe = "dev/wheatstone";
  std::filesystem::create_directories(root_ / probe);
  if (!std::filesystem::exists(std::filesystem::path("/") / probe))
    throw DeviceError(Kind::kNotReady, "devices cannot be emulated here",
                      "start the program by umockdev-wrapper");
}

void MockBed::add(const std::string& description) {
  GError* error = nullptr;
  const bool added = umockdev_testbed_add_from_string(bed_.get(), description.c_str(), &error);
  require(added, error, "an emulated device cannot be plugged in");
}

void MockBed::attach(const std::filesystem::path& node, UMockdevIoctlBase* handler) {
  GError* error = nullptr;
  const bool attached = umockdev_testbed_attach_ioctl(bed_.get(), node.c_str(), handler, &error);
  require(attached, error, "an emulated device cannot answer");
}

void MockBed::detach(const std::filesystem::path& node) {
  umockdev_testbed_detach_ioctl(bed_.get(), node.c_str(), nullptr);
}

void MockBed::remove(const std::vector<std::string>& sys_paths) {
  if (!sys_paths.empty()) umockdev_testbed_uevent(bed_.get(), sys_paths.front().c_str(), "remove");
  for (const std::string& path : sys_paths)
    umockdev_testbed_remove_device(bed_.get(), path.c_str());
}

}  // namespace wheatstone
