// Random numbers for spans, for host code that is not a wide kernel itself. See kinora/random.h for what they are.
#pragma once
#include <kinora/sample_table.h>

namespace kinora {

// u, v for n entries (padded): dimension of the (seed, sample) address of each.
using DrawSpan = void (*)(const SampleTable& table, uint32_t n, const uint32_t* seed, const uint32_t* sample,
                          uint32_t dimension, float* u, float* v);
DrawSpan drawSpan(uint32_t width);
// The same with sample * parts + part: sub-sample of a split.
using DrawSplit = void (*)(const SampleTable& table, uint32_t n, const uint32_t* seed, const uint32_t* sample,
                           uint32_t dimension, uint32_t part, uint32_t parts, float* u, float* v);
DrawSplit drawSplit(uint32_t width);
// One number for an event of an unbounded loop; scalar (rare).
float drawEvent(uint32_t seed, uint32_t sample, uint32_t dimension, uint32_t event);

}  // namespace kinora
