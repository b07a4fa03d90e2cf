// Colours as formats of straight alpha mean them (PNG, TGA): those of what covers the pixel, without its alpha. Called by
// film/ for displays and by read_write.cpp for other pictures.
#pragma once
#include <cstddef>
#include <vector>

#include "image/image.h"

namespace kinora::image {

// Divides the colours (indices of channels) by alpha. Where nothing covers a pixel its colour stays as it is: a sky that
// the camera sees, a picture behind, a glow. Such light stands behind the edges of what covers too, and would be divided
// with it, far too bright: it is carried on from the pixels where nothing covers and taken away first. Pixels that a
// filter's lobes cover more than wholly stay.
void makeStraight(Image& image, const std::vector<size_t>& colors, size_t alpha);

}  // namespace kinora::image
