// What a frame leaves in the statistics when it has all of its samples, or was stopped. Called by Renderer.
#pragma once
#include "film/film.h"
#include "render/frame.h"
#include "render/statistics.h"
#include "render/world_build.h"

namespace kinora::render {

// Counters of the loop, the film, surfaces, volumes and textures, and who holds how much memory.
void addFrame(const Frame& frame, const film::Film& film, WorldBuilder& builder, Statistics& statistics);

}  // namespace kinora::render
