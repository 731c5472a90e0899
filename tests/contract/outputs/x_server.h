#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace wheatstone {

/// An X server of its own without a screen that anybody sees (Xvfb): one output, "screen".
class XServer {
 public:
  explicit XServer(const std::vector<std::string>& options = {});
  ~XServer();
  XServer(const XServer&) = delete;
  XServer& operator=(const XServer&) = delete;

  const std::string& display() const { return display_; }
  void freeze();
  void thaw();
  void kill();

  // What another client does to it, and sees.
  void set_edid(std::span<const std::byte>);
  /// A property of the output as video drivers have them.
  void set_choice(const std::string& property, const std::string& value);
  void set_integers(const std::string& property, const std::vector<std::uint32_t>& values);
  void set_gamma(const std::vector<std::uint16_t>&);
  std::vector<std::uint16_t> gamma() const;

 private:
  pid_t process_ = -1;
  std::string display_;
};

}  // namespace wheatstone
