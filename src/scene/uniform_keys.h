// How many keys at even distances over the shutter stand for keys at any times. Embree and shading know even keys
// only; asked by render/ for deformation and camera, by trace/ for placements.
#pragma once
#include <span>

namespace kinora::scene {

inline constexpr int kMostUniformKeys = 65;  // over a shutter, of anything

// The least number, at most `most`, with which each time inside (open, close) falls on an even key; where none does,
// the one that misses them least. 1 for a closed shutter.
int uniformKeyCount(std::span<const double> times, double open, double close, int most);

// Whether two of the times, which increase, are nearer to each other within the shutter than two of the most keys: what
// happens between them takes longer then.
bool areCloserThanKeys(std::span<const double> times, double open, double close);

}  // namespace kinora::scene
