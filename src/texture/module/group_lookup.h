// Bilinear and trilinear lookups for a group of points, straight from the tiles of OpenImageIO's cache: a thread keeps
// the tiles that it has used last, the four channels are filtered together, the mip level follows from the footprint. Called
// by TextureSystem for the filters that most lookups use; the rest go through OpenImageIO's own call. A lookup's
// value is that of one point alone: others only share the search for tiles.
#pragma once
#include <OpenImageIO/imagecache.h>

#include <array>
#include <cstdint>
#include <vector>

namespace kinora::texture {

enum class Wrap : uint8_t { Black, Clamp, Periodic };

// One file in the cache, ready for lookups.
struct Pyramid {
  struct Level {
    int width = 0, height = 0;
    int tileWidth = 0, tileHeight = 0;
    int shiftX = -1, shiftY = -1;  // log2 of the tile's sides, -1 when they are no powers of two
  };
  // the finest level's entry, and that of all coarser ones: another one where the file has no levels of its own
  OIIO::ImageCache::ImageHandle *finest = nullptr, *coarse = nullptr;
  std::vector<Level> levels;
  int channels = 0;
  mutable bool isBroken = false;  // a tile could not be read; atomic access
  // False when the file's levels cannot be learned.
  bool describe(OIIO::ImageCache& cache, OIIO::ImageCache::Perthread* thread, OIIO::ustring finestName,
                OIIO::ustring coarseName);
};

struct LookupKind {
  Wrap wrapS = Wrap::Periodic, wrapT = Wrap::Periodic;
  bool blendLevels = true;
  int firstChannel = 0, channels = 4;  // channels: 1 to 4
};

// Holds on to the tiles that a thread's lookups have used last, `mostBytes` of them and one more at most; the cache
// keeps what is held here beside its own limit. They go back when it ends.
class TileTable {
 public:
  explicit TileTable(OIIO::ImageCache& cache) : cache_(cache) {}
  ~TileTable();
  TileTable(const TileTable&) = delete;
  TileTable& operator=(const TileTable&) = delete;

  // `channels` values at (s, t) (t down) filtered over a texel of width `radius` in texture space; coordinates within
  // +-256 and finite. False when a tile cannot be read: the cache has the reason.
  bool lookUp(const Pyramid& pyramid, const LookupKind& kind, float s, float t, float radius, float* out);
  // Of the calling thread, before a group's lookups.
  void enter(OIIO::ImageCache::Perthread* thread, uint64_t mostBytes) {
    thread_ = thread;
    mostBytes_ = mostBytes;
  }

 private:
  struct Tile {
    const Pyramid* pyramid = nullptr;
    int level = 0, x = 0, y = 0;  // in tiles
    OIIO::ImageCache::Tile* handle = nullptr;
    const char* pixels = nullptr;
    uint32_t bytes = 0;   // of the tile's pixels
    uint32_t stride = 0;  // of one pixel
    int type = 0;         // OIIO::TypeDesc::BASETYPE
  };
  const Tile* find(const Pyramid& p, int level, int tileX, int tileY);
  template <class Vector>
  bool bilinear(const Pyramid& p, const LookupKind& kind, int level, float s, float t, Vector& out);

  void release();

  static constexpr uint32_t kTiles = 512;
  OIIO::ImageCache& cache_;
  OIIO::ImageCache::Perthread* thread_ = nullptr;
  uint64_t mostBytes_ = 0;
  uint64_t bytes_ = 0;  // held
  std::array<Tile, kTiles> tiles_{};
};

}  // namespace kinora::texture
