#pragma once
// Inside of exr.cpp and exr_views.cpp: opening a file that may be damaged or hostile.

#include <OpenEXR/ImfMultiPartInputFile.h>

#include <exception>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/image.h"

namespace wheatstone::detail {

inline constexpr int kMaxExrSide_px = 16384;
inline constexpr double kMaxExrPixels = 200e6;

/// Opens a flat file whose header fits the file's own length: no part deep, windows within the
/// limits of read_exr, every chunk table inside the file, every part complete.
/// May throw FileError, or what the library throws; call it inside with_file_errors.
std::unique_ptr<Imf::MultiPartInputFile> open_exr(const std::filesystem::path&);

/// Reads `channels` (file names, all in part `part`) as float, placed in the display window.
/// Shape [channel][display height][display width]; 0 outside the data window.
/// Errors: FileError if a channel is subsampled; library exceptions for damaged pixels.
std::vector<cv::Mat1f> read_channels(const std::filesystem::path&, Imf::MultiPartInputFile&,
                                     int part, const std::vector<std::string>& channels);

/// Runs read(); whatever it throws that is not FileError becomes FileError naming `path`.
template <class Read>
auto with_file_errors(const std::filesystem::path& path, const Read& read) {
  const std::string remedy = "make or copy the file again; it is damaged or not an OpenEXR image";
  try {
    return read();
  } catch (const FileError&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw FileError(path, "not enough memory to read this image",
                    "close other programs, or use a smaller image");
  } catch (const std::exception& e) {
    throw FileError(path, std::string("cannot be read: ") + e.what(), remedy);
  } catch (...) {
    throw FileError(path, "cannot be read", remedy);
  }
}

}  // namespace wheatstone::detail
