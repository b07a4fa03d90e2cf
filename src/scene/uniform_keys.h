// How many keys at even distances over the shutter stand for keys at any times. Embree and shading know even keys
// only; asked by render/ for deformation and camera, by trace/ for placements.
#pragma once
#include <span>

namespace kinora::scene {

// The least number, at most `most`, with which each time inside (open, close) falls on an even key; where none does,
// the one that misses them least. 1 for a closed shutter.
int uniformKeyCount(std::span<const double> times, double open, double close, int most);

}  // namespace kinora::scene
