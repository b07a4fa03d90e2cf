// The trim curves of a NURBS surface as closed loops of short segments in its unit square. Used by the maker of
// patches; how a grid is cut by them stands in trim_cells.h.
#pragma once
#include "geometry/tensor_surface.h"
#include "geometry/trim_cells.h"

namespace kinora::geometry {

struct Trim {
  TrimLoops loops;  // none: the surface is whole
  bool keepInside = true;
};

// Segments leave the curve by no more than dicing leaves arcs. What cannot be used is reported: a curve with wrong
// numbers takes its loop along, a loop that is open is closed by a straight line.
Trim readTrim(const scene::Primitive& primitive, const scene::NuPatch& patch, const TensorSurface& surface,
              const DiceRate& rate, Diagnostics& diagnostics);

}  // namespace kinora::geometry
