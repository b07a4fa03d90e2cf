// What the names in noise("name", ...) mean. Plain, for the compiler and the machine.
#pragma once
#include <string>
#include <string_view>

namespace kinora::language {

enum class NoiseKind {
  Unknown,
  Perlin,
  UnsignedPerlin,
  Cell,
  Hash,
  Simplex,
  UnsignedSimplex,
  Gabor,
  Null,
  UnsignedNull
};

// `constant`: the name is known when the shader is compiled; fewer names are accepted then, as in the reference.
// Unknown also for a noise that has no periodic form.
constexpr NoiseKind noiseKind(std::string_view n, bool periodic, bool constant) {
  if (n == "perlin" || n == "snoise" || n == "psnoise") return NoiseKind::Perlin;
  if (n == "uperlin" || n == "noise" || n == "pnoise") return NoiseKind::UnsignedPerlin;
  if (n == "cell" || n == "cellnoise") return NoiseKind::Cell;
  if (n == "hash" || n == "hashnoise") return NoiseKind::Hash;
  if (n == "gabor") return NoiseKind::Gabor;
  if (!constant && n == "null") return NoiseKind::Null;
  if (!constant && n == "unull") return NoiseKind::UnsignedNull;
  if (periodic) return NoiseKind::Unknown;
  if (n == "simplex" || (!constant && n == "simplexnoise")) return NoiseKind::Simplex;
  if (n == "usimplex" || (!constant && n == "usimplexnoise")) return NoiseKind::UnsignedSimplex;
  return NoiseKind::Unknown;
}
// The reference's words for an unknown name; the position is that of the call.
inline std::string unknownNoise(std::string_view name, bool periodic, std::string_view file, int line) {
  return (periodic ? "periodic noise type \"" : "noise type \"") + std::string(name) +
         "\" is unknown, called from (" + std::string(file) + ":" + std::to_string(line) + ")";
}

}  // namespace kinora::language
