#include "texture/module/group_lookup.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstring>
#include <functional>

namespace kinora::texture {
namespace {

using V4f = float __attribute__((vector_size(16)));
using V4i = int32_t __attribute__((vector_size(16)));

int shiftOf(int side) { return side > 0 && (side & (side - 1)) == 0 ? std::countr_zero(unsigned(side)) : -1; }

// Exact for all halves but NaN's payload, also where the thread flushes denormal floats.
inline V4f fromHalf(V4i h) {
  const V4i sign = (h & 0x8000) << 16, rest = (h & 0x7fff) << 13;
  constexpr int32_t kLeast = 0x38800000;  // the least normal half
  const V4i least = V4i{} + kLeast;
  const V4f small = std::bit_cast<V4f>(rest + kLeast) - std::bit_cast<V4f>(least);
  const V4i large = rest + 0x38000000 + ((rest >= 0x0f800000) & 0x38000000);
  return std::bit_cast<V4f>((rest < 0x00800000 ? std::bit_cast<V4i>(small) : large) | sign);
}

using V8u = uint16_t __attribute__((vector_size(16)));
inline V4i widened(V8u v) { return std::bit_cast<V4i>(__builtin_shuffle(v, V8u{}, V8u{0, 8, 1, 9, 2, 10, 3, 11})); }

// Four channels; those beyond the texel's own are whatever follows it.
inline V4f decoded(const char* texel, int type) {
  if (type == OIIO::TypeDesc::UINT8) {
    using V16u = uint8_t __attribute__((vector_size(16)));
    uint32_t word;
    std::memcpy(&word, texel, 4);
    const V16u bytes = std::bit_cast<V16u>(V4i{int32_t(word), 0, 0, 0});
    const V16u twice = __builtin_shuffle(bytes, V16u{}, V16u{0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23});
    return __builtin_convertvector(widened(std::bit_cast<V8u>(twice)), V4f) * (1.f / 255.f);
  }
  if (type == OIIO::TypeDesc::FLOAT) {
    V4f v;
    std::memcpy(&v, texel, 16);
    return v;
  }
  V8u h{};
  std::memcpy(&h, texel, 8);
  if (type == OIIO::TypeDesc::HALF) return fromHalf(widened(h));
  return __builtin_convertvector(widened(h), V4f) * (1.f / 65535.f);
}

uint32_t channelBytes(int type) { return type == OIIO::TypeDesc::UINT8 ? 1 : type == OIIO::TypeDesc::FLOAT ? 4 : 2; }

// Of numbers whose integers fit.
inline int floorOf(float x) {
  const int i = int(x);
  return i - (float(i) > x);
}

alignas(16) constexpr char kBlack[16] = {};

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
                       OIIO::ustring coarseName, bool isApart) {
  apart = isApart;
  finest = cache.get_image_handle(finestName, thread);
  coarse = coarseName == finestName ? finest : cache.get_image_handle(coarseName, thread);
  if (!finest || !coarse) return false;
  static const OIIO::ustring kLevels("miplevels");
  int count = 0;
  if (!cache.get_image_info(coarse, thread, 0, 0, kLevels, OIIO::TypeInt, &count) || count < 1) return false;
  levels.clear();
  for (int i = 0; i < count + apart; ++i) {
    const OIIO::ImageSpec* spec = cache.imagespec(i == 0 ? finest : coarse, thread, 0, i == 0 ? 0 : i - apart);
    // s and t span the display window: OpenImageIO's call serves pictures that are cropped
    if (!spec || spec->width < 1 || spec->height < 1 || spec->tile_width < 1 || spec->tile_height < 1 || spec->x ||
        spec->y || spec->full_x || spec->full_y || spec->full_width != spec->width ||
        spec->full_height != spec->height)
      return false;
    if (i == 0) {
      const OIIO::ImageSpec* stored = cache.imagespec(finest, thread, 0, 0, true);
      isStrips = stored && stored->tile_width < 1;
    }
    levels.push_back({spec->width, spec->height, spec->tile_width, spec->tile_height, shiftOf(spec->tile_width),
                      shiftOf(spec->tile_height)});
    channels = spec->nchannels;
    texelBytes = std::max(texelBytes, uint32_t(spec->pixel_bytes()));
  }
  // a tile of many channels is read whole
  constexpr int kMostChannels = 8;
  return channels >= 1 && channels <= kMostChannels;
}

TileTable::~TileTable() {
  for (Tile& t : tiles_)
    if (t.handle) cache_.release_tile(t.handle);
  for (OIIO::ImageCache::Tile* t : leaving_) cache_.release_tile(t);
  for (uint32_t i = 0; i < fetchedCount_; ++i)
    if (fetched_[i].handle) cache_.release_tile(fetched_[i].handle);
}

void TileTable::giveBack(Tile& t) {
  bytes_ -= t.bytes;
  if (t.used == block_)
    leaving_.push_back(t.handle);
  else
    cache_.release_tile(t.handle);
  t = Tile();
}

// Tiles go in turn, those of this block excepted, until no more than that many bytes are held.
void TileTable::makeRoom(uint64_t left) {
  for (uint32_t k = 0; k < kSets && bytes_ > left; ++k) {
    hand_ = (hand_ + 1) % kSets;
    for (uint32_t way = 0; way < kWays; ++way) {
      Tile& t = tiles_[hand_ * kWays + way];
      if (t.handle && t.used != block_) giveBack(t);
    }
  }
}

TileTable::Tile& TileTable::put(const Tile& tile, Tile& place) {
  if (place.handle) giveBack(place);
  if (bytes_ > mostBytes_) makeRoom(mostBytes_ / 4 * 3);
  place = tile;
  place.used = block_;
  bytes_ += tile.bytes;
  return place;
}

// The cache keeps a tile that it could not read, and hands it out the next time: no lookup asks for the file again.
void TileTable::markBroken(const Pyramid& p) { std::atomic_ref(p.isBroken).store(true, std::memory_order_relaxed); }

bool TileTable::describe(Tile& tile, const Pyramid& p, uint64_t place, OIIO::ImageCache::Tile* handle) {
  tile = Tile();
  tile.pyramid = &p;
  tile.place = place;
  OIIO::TypeDesc format;
  const char* pixels = handle ? static_cast<const char*>(cache_.tile_pixels(handle, format)) : nullptr;
  const bool isKnown = format.basetype == OIIO::TypeDesc::UINT8 || format.basetype == OIIO::TypeDesc::UINT16 ||
                       format.basetype == OIIO::TypeDesc::HALF || format.basetype == OIIO::TypeDesc::FLOAT;
  if (!pixels || !isKnown) {
    if (handle) cache_.release_tile(handle);
    markBroken(p);
    return false;
  }
  const Pyramid::Level& l = p.levels[size_t(levelOf(place))];
  tile.handle = handle;
  tile.pixels = pixels;
  tile.type = format.basetype;
  tile.stride = uint32_t(format.size()) * uint32_t(p.channels);
  tile.bytes = tile.stride * uint32_t(l.tileWidth) * uint32_t(l.tileHeight);
  return true;
}

const TileTable::Tile* TileTable::find(const Pyramid& p, int level, int tileX, int tileY) {
  const uint64_t place = placeOf(level, tileX, tileY);
  Tile* const set = &tiles_[hashOf(p, level, tileX, tileY) % kSets * kWays];
  Tile* oldest = set;
  for (uint32_t way = 0; way < kWays; ++way) {
    Tile& t = set[way];
    if (t.place == place && t.pyramid == &p) {
      t.used = block_;
      return &t;
    }
    if (!t.handle || (oldest->handle && block_ - t.used > block_ - oldest->used)) oldest = &t;
  }
  return lacking(p, place, *oldest);
}

const TileTable::Tile* TileTable::lacking(const Pyramid& p, uint64_t place, Tile& oldest) {
  if (when_ != When::Now) {
    // stands for it: reads as 0, and the lookup is taken back
    static constexpr Tile kAwaited{};
    isAwaiting_ = true;
    want(p, place);
    return &kAwaited;
  }
  if (const Tile* const t = fetchedAt(p, place)) return t->handle ? t : nullptr;
  TileRead one = readOf(p, place);
  read(&one, 1);
  Tile tile;
  return describe(tile, p, place, one.tile) ? &put(tile, oldest) : nullptr;
}

void TileTable::read(TileRead* reads, uint32_t count) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  readers_.read(reads, count, thread_, why_);
  constexpr uint32_t kAveraged = 32;
  const float each = std::chrono::duration<float, std::micro>(Clock::now() - start).count() / float(count);
  lag_ += (each - lag_) * (float(std::min(count, kAveraged)) / float(kAveraged));
}

TileRead TileTable::readOf(const Pyramid& p, uint64_t place) {
  const int level = levelOf(place);
  const Pyramid::Level& l = p.levels[size_t(level)];
  TileRead read;
  read.file = level == 0 ? p.finest : p.coarse;
  read.level = level == 0 ? 0 : level - p.apart;
  read.x = tileXOf(place) * l.tileWidth;
  read.y = tileYOf(place) * l.tileHeight;
  return read;
}

const TileTable::Tile* TileTable::fetchedAt(const Pyramid& p, uint64_t place) const {
  const auto isBefore = [](const Tile& a, const Wanted& b) {
    return a.pyramid == b.pyramid ? a.place < b.place : std::less<>()(a.pyramid, b.pyramid);
  };
  const Tile* const end = fetched_ + fetchedCount_;
  const Tile* const t = std::lower_bound(fetched_, end, Wanted{&p, place}, isBefore);
  return t != end && t->pyramid == &p && t->place == place ? t : nullptr;
}

void TileTable::want(const Pyramid& p, uint64_t place) {
  uint32_t at = uint32_t((place ^ reinterpret_cast<uintptr_t>(&p)) * 0x9E3779B97F4A7C15u >> (64 - kSlotBits));
  for (; slots_[at]; at = (at + 1) % kSlots)
    if (const Wanted& w = wanted_[slots_[at] - 1]; w.place == place && w.pyramid == &p) return;
  const Pyramid::Level& l = p.levels[size_t(levelOf(place))];
  const uint64_t bytes = uint64_t(p.texelBytes) * uint64_t(l.tileWidth) * uint64_t(l.tileHeight);
  if (wantedCount_ == kMostWanted || wantedBytes_ + bytes > mostBytes_ / 2) {
    isCrowded_ = true;
    return;
  }
  wanted_[wantedCount_++] = {&p, place};
  wantedBytes_ += bytes;
  slots_[at] = uint16_t(wantedCount_);
}

void TileTable::fetch() {
  if (!wantedCount_) return;
  std::sort(wanted_, wanted_ + wantedCount_, [](const Wanted& a, const Wanted& b) {
    return a.pyramid == b.pyramid ? a.place < b.place : std::less<>()(a.pyramid, b.pyramid);
  });
  if (bytes_ + wantedBytes_ > mostBytes_) makeRoom(mostBytes_ - wantedBytes_);
  for (uint32_t i = 0; i < wantedCount_; ++i) {
    const auto& [p, place] = wanted_[i];
    reads_[i] = readOf(*p, place);
    reads_[i].isWithPrevious = p->isStrips && i > 0 && wanted_[i - 1].pyramid == p;
  }
  read(reads_, wantedCount_);
  for (uint32_t i = 0; i < wantedCount_; ++i)
    describe(fetched_[i], *wanted_[i].pyramid, wanted_[i].place, reads_[i].tile);
  fetchedCount_ = wantedCount_;
}

void TileTable::settle() {
  for (uint32_t i = 0; i < fetchedCount_; ++i) {
    const Tile& t = fetched_[i];
    if (!t.handle) continue;
    Tile* const set =
        &tiles_[hashOf(*t.pyramid, levelOf(t.place), tileXOf(t.place), tileYOf(t.place)) % kSets * kWays];
    const auto age = [&](const Tile& x) { return x.handle ? block_ - x.used : ~0u; };
    put(t, *std::max_element(set, set + kWays, [&](const Tile& a, const Tile& b) { return age(a) < age(b); }));
  }
  if (wantedCount_) std::memset(slots_, 0, sizeof slots_);
  wantedCount_ = fetchedCount_ = 0;
  wantedBytes_ = 0;
  isCrowded_ = false;
  if (!leaving_.empty()) endBlock();
}

inline uint32_t TileTable::offsetOf(const Tile& tile, uint32_t at, const LookupKind& kind) {
  return at * tile.stride + uint32_t(kind.firstChannel) * channelBytes(tile.type);
}

// What would be read beyond the tile counts as 0.
inline const char* TileTable::texelAt(const Tile& tile, uint32_t offset) {
  if (offset + kTexelBytes <= tile.bytes) return tile.pixels + offset;
  char* const copy = end_[ends_++];
  std::memset(copy, 0, kTexelBytes);
  if (offset < tile.bytes) std::memcpy(copy, tile.pixels + offset, tile.bytes - offset);
  return copy;
}

template <int kSide>
bool TileTable::texels(const Pyramid& p, const LookupKind& kind, int level, int x, int y, const char** out,
                       int& type) {
  const Pyramid::Level& l = p.levels[size_t(level)];
  int xs[kSide], ys[kSide], tx[kSide], ty[kSide];
  bool isOneTile = true;
  for (int i = 0; i < kSide; ++i) {
    xs[i] = wrapped(x + i, l.width, kind.wrapS);
    ys[i] = wrapped(y + i, l.height, kind.wrapT);
    tx[i] = l.shiftX >= 0 ? xs[i] >> l.shiftX : xs[i] / l.tileWidth;
    ty[i] = l.shiftY >= 0 ? ys[i] >> l.shiftY : ys[i] / l.tileHeight;
    isOneTile = isOneTile && tx[i] == tx[0] && ty[i] == ty[0] && (xs[i] | ys[i]) >= 0;
  }
  const auto within = [&](int i, int j) {
    return uint32_t(ys[j] - ty[j] * l.tileHeight) * uint32_t(l.tileWidth) + uint32_t(xs[i] - tx[i] * l.tileWidth);
  };
  if (isOneTile) {  // as nearly always
    const Tile* const tile = find(p, level, tx[0], ty[0]);
    if (!tile) return false;
    type = tile->type;
    for (int j = 0; j < kSide; ++j) {
      for (int i = 0; i < kSide; ++i) out[j * kSide + i] = texelAt(*tile, offsetOf(*tile, within(i, j), kind));
      __builtin_prefetch(out[j * kSide]);  // neighbours in a row mostly share a line of the CPU's cache
    }
    return true;
  }
  const Tile* tile = nullptr;
  int tileX = 0, tileY = 0;
  type = OIIO::TypeDesc::UINT8;
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i) {
      out[j * kSide + i] = kBlack;
      if (xs[i] < 0 || ys[j] < 0) continue;
      if (!tile || tileX != tx[i] || tileY != ty[j]) {
        tileX = tx[i];
        tileY = ty[j];
        tile = find(p, level, tileX, tileY);
        if (!tile) return false;
        type = tile->type;
      }
      out[j * kSide + i] = texelAt(*tile, offsetOf(*tile, within(i, j), kind));
      __builtin_prefetch(out[j * kSide + i]);
    }
  return true;
}

bool TileTable::tap(const Pyramid& p, const LookupKind& kind, int level, float s, float t, Tap& tap) {
  const Pyramid::Level& l = p.levels[size_t(level)];
  const float x = s * float(l.width) - 0.5f, y = t * float(l.height) - 0.5f;
  const int ix = floorOf(x), iy = floorOf(y);
  tap.x = x - float(ix);
  tap.y = y - float(iy);
  return texels<2>(p, kind, level, ix, iy, tap.texel, tap.type);
}

bool TileTable::cubicTap(const Pyramid& p, const LookupKind& kind, float s, float t, CubicTap& tap) {
  const Pyramid::Level& l = p.levels[0];
  const float x = s * float(l.width) - 0.5f, y = t * float(l.height) - 0.5f;
  const int ix = floorOf(x), iy = floorOf(y);
  const auto weights = [](float f, float w[4]) {
    const float g = 1.f - f;
    w[0] = g * g * g * (1 / 6.f);
    w[1] = 2 / 3.f - 0.5f * f * f * (2.f - f);
    w[2] = 2 / 3.f - 0.5f * g * g * (2.f - g);
    w[3] = f * f * f * (1 / 6.f);
  };
  weights(x - float(ix), tap.x);
  weights(y - float(iy), tap.y);
  return texels<4>(p, kind, 0, ix - 1, iy - 1, tap.texel, tap.type);
}

// Level k where the footprint spans 2^k texels of the finest one, in between a mix in proportion.
TileTable::LevelMix TileTable::mixOf(const Pyramid& p, const LookupKind& kind, float texels) {
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
  return {level, blend};
}

TileTable::Reply TileTable::ask(const Pyramid& p, const LookupKind& kind, LevelMix mix, float s, float t, When when) {
  if (std::atomic_ref(p.isBroken).load(std::memory_order_relaxed)) return Reply::Unreadable;
  const auto [level, blend] = mix;
  Tap* const taps = &taps_[2 * asked_];
  const uint32_t ends = ends_;
  const bool isCubic = kind.isCubic && level == 0;
  when_ = when;
  isAwaiting_ = when == When::Never;
  const bool isThere = isCubic ? cubicTap(p, kind, s, t, cubic_[asked_]) : tap(p, kind, level, s, t, taps[0]);
  const bool isReadable = isThere && (blend <= 0 || tap(p, kind, level + 1, s, t, taps[1]));
  if (!isReadable || isAwaiting_) {
    ends_ = ends;
    return isReadable ? Reply::Awaited : Reply::Unreadable;
  }
  isCubic_[asked_] = isCubic;
  blend_[asked_++] = blend;
  return Reply::Taken;
}

void TileTable::answer(float (*out)[4]) {
  const auto filtered = [](const Tap& tap) {
    V4f c[4];
    for (int k = 0; k < 4; ++k) c[k] = decoded(tap.texel[k], tap.type);
    const V4f top = c[0] + (c[1] - c[0]) * tap.x, bottom = c[2] + (c[3] - c[2]) * tap.x;
    return top + (bottom - top) * tap.y;
  };
  const auto cubic = [](const CubicTap& tap) {
    V4f sum{};
    for (int j = 0; j < 4; ++j) {
      V4f row{};
      for (int i = 0; i < 4; ++i) row += decoded(tap.texel[4 * j + i], tap.type) * tap.x[i];
      sum += row * tap.y[j];
    }
    return sum;
  };
  for (uint32_t i = 0; i < asked_; ++i) {
    V4f value = isCubic_[i] ? cubic(cubic_[i]) : filtered(taps_[2 * i]);
    if (blend_[i] > 0) {
      const V4f coarser = filtered(taps_[2 * i + 1]);
      value = value + (coarser - value) * blend_[i];
    }
    std::memcpy(out[i], &value, sizeof value);
  }
  endBlock();
}

void TileTable::endBlock() {
  asked_ = ends_ = 0;
  ++block_;
  for (OIIO::ImageCache::Tile* t : leaving_) cache_.release_tile(t);
  leaving_.clear();
}

}  // namespace kinora::texture
