#pragma once
// Grey textures for CaMoJAB: from files, and the ones of its reference vectors.

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace wheatstone {

/// Weights of R, G, B in a grey value, as in the released programs.
inline constexpr double kGreyWeights[3] = {0.298936021293775, 0.587043074451121, 0.114020904255103};

/// [row][column], values as stored. An OpenEXR file has a channel Y, or R, G and B; any other
/// picture has 8 or 16 bits, grey or colour, and is divided by its full code. No linearisation.
/// Errors: FileError: missing, damaged, other channels, multi-view, NaN or infinite (first place).
cv::Mat1d read_grey_texture(const std::filesystem::path&);

/// The names procedural_texture() knows.
std::vector<std::string> procedural_texture_names();

/// One of the textures that the reference vectors define, e.g. "checker512".
/// Errors: ArgumentError for an unknown name, listing those known.
cv::Mat1d procedural_texture(const std::string& name);

}  // namespace wheatstone
