#pragma once
// Fingerprints of files, as `sha256sum` prints them.

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

namespace wheatstone {

/// SHA-256 (FIPS 180-4) as 64 lower-case hexadecimal digits.
std::string sha256_hex(std::span<const std::byte>);

/// The same of a whole file. FileError if it is missing or unreadable.
std::string sha256_hex_of(const std::filesystem::path&);

}  // namespace wheatstone
