// What a homogeneous absorber lets through, by our own exponential: the same bits with every C library. Called by the
// media stack for one segment at a time; it knows no geometry.
#pragma once

namespace kinora::shade {

// exp(-absorption * distance); 1 without absorption, 0 over an endless way. absorption >= 0, per unit of distance.
float beerLambert(float absorption, float distance);
// The optical depth at which a ray ends that u in [0, 1) was drawn for: -log(1 - u).
float freeDepth(float u);

}  // namespace kinora::shade
