#include "core/digest.h"

#include <openssl/evp.h>

#include <array>

#include "core/error.h"
#include "core/files.h"

namespace wheatstone {

std::string sha256_hex(std::span<const std::byte> bytes) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  if (EVP_Digest(bytes.data(), bytes.size(), digest.data(), &size, EVP_sha256(), nullptr) != 1)
    throw InternalError("the library refuses SHA-256");
  constexpr char kDigits[] = "0123456789abcdef";
  std::string hex;
  for (unsigned i = 0; i < size; ++i) {
    hex += kDigits[digest[i] >> 4];
    hex += kDigits[digest[i] & 15];
  }
  return hex;
}

std::string sha256_hex_of(const std::filesystem::path& path) {
  return sha256_hex(read_bytes(path));
}

}  // namespace wheatstone
