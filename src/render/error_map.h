// How much noise each pixel of a picture still has, for statistics. Called by Renderer when a frame is done.
#pragma once
#include <array>

#include "film/film.h"
#include "render/statistics.h"

namespace kinora::render {

// The relative error of each pixel, from its even and its odd samples (halves: channels of the film that hold them). Nothing
// where these are not measured.
PixelMap errorMapOf(const film::Film& film, const std::array<int, 2>& halves);

}  // namespace kinora::render
