#pragma once
// umockdev with owners: devices that exist in /dev and /sys for this program and its children only.

#include <umockdev.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace wheatstone {

struct UnrefObject {
  void operator()(void* p) const { g_object_unref(p); }
};
/// A GObject, or one of umockdev's.
template <class T>
using Owned = std::unique_ptr<T, UnrefObject>;

/// The machine's devices as the program and its children see them: none but the emulated ones. One
/// at a time in a process.
class MockBed {
 public:
  /// Throws DeviceError kNotReady unless the program was started by umockdev-wrapper.
  MockBed();

  /// Where the tree really lies: its "dev", its "sys".
  const std::filesystem::path& root() const { return root_; }
  /// `description` in umockdev's own format. Throws DeviceError kFault. Nodes need contents: one
  /// without is a terminal, which umockdev 0.17 cannot make twice.
  void add(const std::string& description);
  /// The handler answers ioctl(), read() and write() of this node, in a thread of umockdev.
  void attach(const std::filesystem::path& node, UMockdevIoctlBase* handler);
  void detach(const std::filesystem::path& node);
  /// What is plugged out, the innermost device first; udev tells of that one.
  void remove(const std::vector<std::string>& sys_paths);

 private:
  Owned<UMockdevTestbed> bed_;
  std::filesystem::path root_;
};

}  // namespace wheatstone
