// Bounds of what media extinguish, for tracking, and where they emit, for choosing lights: from their fields, or by shading
// lattices of points. Called by SpaceMediaStage.
#pragma once
#include <atomic>

#include "shade/group.h"
#include "shade/space_media.h"

namespace kinora::render {

// The cells of a medium's bounds: 48 along its longest side, one where its extinction is the same everywhere.
void makeBoundCells(shade::SpaceMedium& m);

// Bounds that fields give.
void boundByFields(shade::SpaceMedium& m);

// Bounds by looking: coarsely everywhere, then finely where something changes. What a cell shows holds for its
// neighbours too, and a little more. The world knows its media.
void boundByShading(shade::SpaceMedium& m, uint32_t index, const shade::ShadingWorld& world,
                    const std::atomic<bool>* stop);

// Which coarser levels of its fields rays see, with bounds of their own, which are lower: means have no peaks. scale: of
// lengths from object space. Not where the medium's networks ask for the fields, which know no levels.
void setLevels(shade::SpaceMedium& m, float filterWidth, float scale);

// Cells that emit, by looking, and higher bounds where it glows. What lies beside one counts a little too: a flame's tip
// may be between the points.
void findEmission(shade::SpaceMedium& m, uint32_t index, const shade::ShadingWorld& world,
                  const std::atomic<bool>* stop);

}  // namespace kinora::render
