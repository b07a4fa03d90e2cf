// Bilinear and trilinear lookups for a group of points, straight from the tiles of OpenImageIO's cache: a thread keeps
// the tiles that it has used last, the four channels are filtered together, the mip level follows from the footprint. Called
// by TextureSystem for the filters that most lookups use; the rest go through OpenImageIO's own call. A lookup's
// value is that of one point alone: others only share the search for tiles.
#pragma once
#include <OpenImageIO/imagecache.h>

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
  int apart = 0;                  // 1: `coarse` begins with the first coarse level, else with the finest
  mutable bool isBroken = false;  // a tile could not be read; atomic access
  // False when the file's levels cannot be learned.
  bool describe(OIIO::ImageCache& cache, OIIO::ImageCache::Perthread* thread, OIIO::ustring finestName,
                OIIO::ustring coarseName, bool isApart = false);
};

struct LookupKind {
  Wrap wrapS = Wrap::Periodic, wrapT = Wrap::Periodic;
  bool blendLevels = true;
  bool isCubic = false;  // the finest level by a cubic B-spline: no facets where texels are larger than the footprint
  int firstChannel = 0, channels = 4;  // channels: 1 to 4
};

// Holds on to the tiles that a thread's lookups have used last, `mostBytes` of them and those of one block at most; the
// cache keeps what is held here beside its own limit. They go back when it ends. Lookups are asked for first and
// answered in blocks: which texels they want is known for the whole block before the first of them is read, so that
// they arrive from memory together.
class TileTable {
 public:
  static constexpr uint32_t kBlock = 32;

  explicit TileTable(OIIO::ImageCache& cache) : cache_(cache), tiles_(kSets * kWays) {}
  ~TileTable();
  TileTable(const TileTable&) = delete;
  TileTable& operator=(const TileTable&) = delete;

  // Of the calling thread, before a group's lookups. Forgets what a group that was broken off has asked for.
  void enter(OIIO::ImageCache::Perthread* thread, uint64_t mostBytes) {
    thread_ = thread;
    mostBytes_ = mostBytes;
    if (asked_) endBlock();
  }
  // Between which levels a lookup lies whose texels are that many wide, counted in those of the finest level.
  struct LevelMix {
    int level = 0;
    float blend = 0;  // share of the next coarser one
  };
  static LevelMix mixOf(const Pyramid& pyramid, const LookupKind& kind, float texels);
  // `kind.channels` values at (s, t) (t down); coordinates within +-256 and finite. False when a tile cannot be read:
  // the cache has the reason. Where isFull(), answer() comes first.
  bool ask(const Pyramid& pyramid, const LookupKind& kind, LevelMix mix, float s, float t);
  bool isFull() const { return asked_ == kBlock; }
  uint32_t asked() const { return asked_; }
  // What has been asked for since the last answer: four numbers each, of which those beyond the file's channels mean
  // nothing.
  void answer(float (*out)[4]);

 private:
  struct Tile {
    const Pyramid* pyramid = nullptr;
    uint64_t place = 0;  // level, x and y
    OIIO::ImageCache::Tile* handle = nullptr;
    const char* pixels = nullptr;
    uint32_t bytes = 0;   // of the tile's pixels
    uint32_t stride = 0;  // of one pixel
    uint32_t used = 0;    // in which block it was wanted last
    int type = 0;         // OIIO::TypeDesc::BASETYPE
  };
  // Four texels of one level, and where between them.
  struct Tap {
    const char* texel[4];
    float x, y;
    int type;
  };
  // Sixteen of the finest level, with the weights of their columns and rows.
  struct CubicTap {
    const char* texel[16];
    float x[4], y[4];
    int type;
  };
  static constexpr uint32_t kWays = 4, kSets = 512;
  static constexpr uint32_t kTexelBytes = 16;  // that may be read from a texel on
  const Tile* find(const Pyramid& p, int level, int tileX, int tileY);
  void endBlock();
  void giveBack(Tile& tile);
  void makeRoom();
  // Texels of kSide columns and rows from (x, y) on. False where a tile cannot be read.
  template <int kSide>
  bool texels(const Pyramid& p, const LookupKind& kind, int level, int x, int y, const char** out, int& type);
  bool tap(const Pyramid& p, const LookupKind& kind, int level, float s, float t, Tap& tap);
  bool cubicTap(const Pyramid& p, const LookupKind& kind, float s, float t, CubicTap& tap);
  static uint32_t offsetOf(const Tile& tile, uint32_t at, const LookupKind& kind);
  const char* texelAt(const Tile& tile, uint32_t offset);

  OIIO::ImageCache& cache_;
  OIIO::ImageCache::Perthread* thread_ = nullptr;
  uint64_t mostBytes_ = 0;
  uint64_t bytes_ = 0;  // held
  std::vector<Tile> tiles_;
  uint32_t block_ = 1;                            // counts answers
  uint32_t hand_ = 0;                             // of the sets, where room was made last
  std::vector<OIIO::ImageCache::Tile*> leaving_;  // replaced, but wanted in this block
  uint32_t asked_ = 0, ends_ = 0;
  Tap taps_[2 * kBlock];
  CubicTap cubic_[kBlock];
  bool isCubic_[kBlock];  // the first tap is that one
  float blend_[kBlock];
  // texels too near to the end of their tile to be read whole
  char end_[20 * kBlock][kTexelBytes];
};

}  // namespace kinora::texture
