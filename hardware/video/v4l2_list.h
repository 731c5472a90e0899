#pragma once
// Names and addresses of V4L2 cameras.

#include <cstdint>
#include <filesystem>
#include <string>

namespace wheatstone {

/// The node with this USB serial that captures. Throws kNotFound if none has it or several do.
std::filesystem::path find_video_node(const std::string& usb_serial);
/// Of the USB device behind the node; empty: it has none.
std::string usb_serial_of(const std::filesystem::path& node);

/// "GREY" and back. Pre: four characters.
std::uint32_t fourcc(const std::string&);
std::string fourcc_name(std::uint32_t);

}  // namespace wheatstone
