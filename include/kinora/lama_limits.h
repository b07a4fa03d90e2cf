// How large a tree of slabs may be: materials of LamaLayer, LamaMix and LamaAdd are flattened into one LamaSurface before
// anything is shaded (shade/layered_bxdfs.h), whose parameters and memory have room for so much.
#pragma once
#include <cstdint>

namespace kinora::lama {

constexpr uint32_t kMaxLeaves = 8;
constexpr uint32_t kMaxBelow = 2;   // leaves that scatter below the surface
constexpr uint32_t kLobeNames = 2;  // that leaves of one tree may give their lobes

}  // namespace kinora::lama
