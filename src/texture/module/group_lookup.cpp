#include "texture/module/group_lookup.h"

#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>

namespace kinora::texture {
namespace {

using V4f = float __attribute__((vector_size(16)));
using V4i = int32_t __attribute__((vector_size(16)));

int shiftOf(int side) { return side > 0 && (side & (side - 1)) == 0 ? std::countr_zero(unsigned(side)) : -1; }

// Exact for all halves but NaN's payload, also where the thread flushes denormal floats.
inline float fromHalf(uint16_t h) {
  const uint32_t sign = uint32_t(h & 0x8000u) << 16, rest = h & 0x7fffu;
  if (rest < 0x400u) return (sign ? -0x1p-24f : 0x1p-24f) * float(rest);
  if (rest >= 0x7c00u) return std::bit_cast<float>(sign | 0x7f800000u | (rest & 0x3ffu) << 13);
  return std::bit_cast<float>(sign | ((rest << 13) + 0x38000000u));
}

// Four channels from `first` on; those beyond the texel's own are whatever follows it. What would be read beyond the
// tile counts as 0.
inline V4f texel(const char* pixels, uint32_t bytes, uint32_t offset, int type, int first) {
  if (type == OIIO::TypeDesc::UINT8) {
    offset += uint32_t(first);
    uint32_t word = 0;
    if (offset + 4 <= bytes)
      std::memcpy(&word, pixels + offset, 4);
    else
      std::memcpy(&word, pixels + offset, bytes - offset);
    const V4i i = {int32_t(word & 255u), int32_t(word >> 8 & 255u), int32_t(word >> 16 & 255u), int32_t(word >> 24)};
    return __builtin_convertvector(i, V4f) * (1.f / 255.f);
  }
  if (type == OIIO::TypeDesc::FLOAT) {
    offset += 4 * uint32_t(first);
    V4f v{};
    if (offset + 16 <= bytes)
      std::memcpy(&v, pixels + offset, 16);
    else
      std::memcpy(&v, pixels + offset, bytes - offset);
    return v;
  }
  offset += 2 * uint32_t(first);
  uint16_t h[4] = {0, 0, 0, 0};
  if (offset + 8 <= bytes)
    std::memcpy(h, pixels + offset, 8);
  else
    std::memcpy(h, pixels + offset, bytes - offset);
  if (type == OIIO::TypeDesc::HALF) return V4f{fromHalf(h[0]), fromHalf(h[1]), fromHalf(h[2]), fromHalf(h[3])};
  return V4f{float(h[0]), float(h[1]), float(h[2]), float(h[3])} * (1.f / 65535.f);
}

// Texel index within [0, size), or -1: black.
inline int wrapped(int i, int size, Wrap wrap) {
  if (unsigned(i) < unsigned(size)) return i;
  switch (wrap) {
    case Wrap::Black:
      return -1;
    case Wrap::Clamp:
      return i < 0 ? 0 : size - 1;
    case Wrap::Periodic:
      break;
  }
  i %= size;
  return i < 0 ? i + size : i;
}

}  // namespace

bool Pyramid::describe(OIIO::ImageCache& cache, OIIO::ImageCache::Perthread* thread, OIIO::ustring finestName,
                       OIIO::ustring coarseName) {
  finest = cache.get_image_handle(finestName, thread);
  coarse = coarseName == finestName ? finest : cache.get_image_handle(coarseName, thread);
  if (!finest || !coarse) return false;
  static const OIIO::ustring kLevels("miplevels");
  int count = 0;
  if (!cache.get_image_info(coarse, thread, 0, 0, kLevels, OIIO::TypeInt, &count) || count < 1) return false;
  levels.clear();
  for (int i = 0; i < count; ++i) {
    const OIIO::ImageSpec* spec = cache.imagespec(i == 0 ? finest : coarse, thread, 0, i);
    // s and t span the display window: OpenImageIO's call serves pictures that are cropped
    if (!spec || spec->width < 1 || spec->height < 1 || spec->tile_width < 1 || spec->tile_height < 1 || spec->x ||
        spec->y || spec->full_x || spec->full_y || spec->full_width != spec->width ||
        spec->full_height != spec->height)
      return false;
    levels.push_back({spec->width, spec->height, spec->tile_width, spec->tile_height, shiftOf(spec->tile_width),
                      shiftOf(spec->tile_height)});
    channels = spec->nchannels;
  }
  // a tile of many channels is read whole
  constexpr int kMostChannels = 8;
  return channels >= 1 && channels <= kMostChannels;
}

TileTable::~TileTable() { release(); }

void TileTable::release() {
  for (Tile& t : tiles_) {
    if (t.handle) cache_.release_tile(t.handle);
    t = Tile();
  }
  bytes_ = 0;
}

const TileTable::Tile* TileTable::find(const Pyramid& p, int level, int tileX, int tileY) {
  const uint32_t pyramid = uint32_t(reinterpret_cast<uintptr_t>(&p) >> 5) * 0x9E3779B1u;
  Tile& t = tiles_[((pyramid >> 16) + uint32_t(tileX) + uint32_t(tileY) * 7u + uint32_t(level) * 29u) % kTiles];
  if (t.handle && t.pyramid == &p && t.level == level && t.x == tileX && t.y == tileY) return &t;
  const Pyramid::Level& l = p.levels[size_t(level)];
  OIIO::ImageCache::Tile* handle = cache_.get_tile(level == 0 ? p.finest : p.coarse, thread_, 0, level,
                                                   tileX * l.tileWidth, tileY * l.tileHeight, 0);
  if (!handle) {
    // the cache keeps a tile that it could not read, and hands it out the next time: the file goes the other way for
    // good
    std::atomic_ref(p.isBroken).store(true, std::memory_order_relaxed);
    return nullptr;
  }
  if (t.handle) {
    cache_.release_tile(t.handle);
    bytes_ -= t.bytes;
    t = Tile();
  }
  if (bytes_ > mostBytes_) release();
  OIIO::TypeDesc format;
  t.handle = handle;
  t.pixels = static_cast<const char*>(cache_.tile_pixels(handle, format));
  t.type = format.basetype;
  t.stride = uint32_t(format.size()) * uint32_t(p.channels);
  t.bytes = t.stride * uint32_t(l.tileWidth) * uint32_t(l.tileHeight);
  bytes_ += t.bytes;
  t.pyramid = &p;
  t.level = level;
  t.x = tileX;
  t.y = tileY;
  const bool known = t.type == OIIO::TypeDesc::UINT8 || t.type == OIIO::TypeDesc::UINT16 ||
                     t.type == OIIO::TypeDesc::HALF || t.type == OIIO::TypeDesc::FLOAT;
  return t.pixels && known ? &t : nullptr;
}

template <class Vector>
bool TileTable::bilinear(const Pyramid& p, const LookupKind& kind, int level, float s, float t, Vector& out) {
  const Pyramid::Level& l = p.levels[size_t(level)];
  const float x = s * float(l.width) - 0.5f, y = t * float(l.height) - 0.5f, fx = std::floor(x), fy = std::floor(y);
  const int ix = int(fx), iy = int(fy);
  const int xs[2] = {wrapped(ix, l.width, kind.wrapS), wrapped(ix + 1, l.width, kind.wrapS)};
  const int ys[2] = {wrapped(iy, l.height, kind.wrapT), wrapped(iy + 1, l.height, kind.wrapT)};
  int tx[2], ty[2];
  for (int i = 0; i < 2; ++i) {
    tx[i] = l.shiftX >= 0 ? xs[i] >> l.shiftX : xs[i] / l.tileWidth;
    ty[i] = l.shiftY >= 0 ? ys[i] >> l.shiftY : ys[i] / l.tileHeight;
  }
  V4f c[4] = {};
  const Tile* tile = nullptr;
  for (int k = 0; k < 4; ++k) {
    const int a = k & 1, b = k >> 1;
    if (xs[a] < 0 || ys[b] < 0) continue;  // black
    if (!tile || tile->x != tx[a] || tile->y != ty[b]) tile = find(p, level, tx[a], ty[b]);
    if (!tile) return false;
    const uint32_t at =
        uint32_t(ys[b] - ty[b] * l.tileHeight) * uint32_t(l.tileWidth) + uint32_t(xs[a] - tx[a] * l.tileWidth);
    c[k] = texel(tile->pixels, tile->bytes, at * tile->stride, tile->type, kind.firstChannel);
  }
  const float ax = x - fx, ay = y - fy;
  const V4f top = c[0] + (c[1] - c[0]) * ax, bottom = c[2] + (c[3] - c[2]) * ax;
  out = top + (bottom - top) * ay;
  return true;
}

bool TileTable::lookUp(const Pyramid& p, const LookupKind& kind, float s, float t, float radius, float* out) {
  if (std::atomic_ref(p.isBroken).load(std::memory_order_relaxed)) return false;
  const Pyramid::Level& finest = p.levels[0];
  // how many texels of the finest level the footprint spans: level k where it spans 2^k, in between a mix in
  // proportion
  const float texels = radius * float(finest.width < finest.height ? finest.width : finest.height);
  int level = 0;
  float blend = 0;
  const int last = int(p.levels.size()) - 1;
  if (texels > 1.f) {
    const uint32_t bits = std::bit_cast<uint32_t>(texels);
    level = int(bits >> 23) - 127;
    blend = std::bit_cast<float>((bits & 0x7fffffu) | 0x3f800000u) - 1.f;
    if (!kind.blendLevels) {
      level += blend >= 0.5f;
      blend = 0;
    }
    if (level >= last) {
      level = last;
      blend = 0;
    }
  }
  V4f value;
  if (!bilinear(p, kind, level, s, t, value)) return false;
  if (blend > 0) {
    V4f coarser;
    if (!bilinear(p, kind, level + 1, s, t, coarser)) return false;
    value = value + (coarser - value) * blend;
  }
  for (int c = 0; c < kind.channels; ++c) out[c] = value[c];
  return true;
}

}  // namespace kinora::texture
