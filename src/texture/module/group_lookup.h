// Bilinear and trilinear lookups for a group of points, straight from the tiles of OpenImageIO's cache: a thread keeps
// the tiles that it has used last, the four channels are filtered together, the mip level follows from the footprint. Tiles
// that it has not are gathered over many lookups and read together, in order. Called
// by TextureSystem for the filters that most lookups use; the rest go through OpenImageIO's own call. A lookup's
// value is that of one point alone: others only share the search for tiles.
#pragma once
#include <OpenImageIO/imagecache.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "texture/module/tile_readers.h"

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
  bool isStrips = false;          // the file has no tiles: the library reads all of a row, and levels from rows
  uint32_t texelBytes = 0;        // at most
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
//
// A lookup that is asked for Later, of which a tile is not held, leaves word which tiles it wants; the caller puts it
// aside, calls fetch() when the group is through (or isCrowded()), asks such lookups once more, Now, answers them, and
// calls settle(). What is asked for Now and was not fetched is read there and then, so that no lookup depends on room.
class TileTable {
 public:
  static constexpr uint32_t kBlock = 32;
  static constexpr uint32_t kMostWanted = 256;

  TileTable(OIIO::ImageCache& cache, TileReaders& readers)
      : cache_(cache), readers_(readers), tiles_(kSets * kWays) {}
  ~TileTable();
  TileTable(const TileTable&) = delete;
  TileTable& operator=(const TileTable&) = delete;

  // Of the calling thread, before a group's lookups. Forgets what a group that was broken off has asked for.
  void enter(OIIO::ImageCache::Perthread* thread, uint64_t mostBytes) {
    thread_ = thread;
    mostBytes_ = mostBytes;
    if (asked_) endBlock();
    settle();
    why_.clear();
  }
  // Between which levels a lookup lies whose texels are that many wide, counted in those of the finest level.
  struct LevelMix {
    int level = 0;
    float blend = 0;  // share of the next coarser one
  };
  static LevelMix mixOf(const Pyramid& pyramid, const LookupKind& kind, float texels);
  enum class When { Now, Later, Never };  // Never: what it lacks is wanted, but it is not to be answered
  enum class Reply { Taken, Awaited, Unreadable };
  // `kind.channels` values at (s, t) (t down); coordinates within +-256 and finite. Unreadable when a tile is: reason()
  // says why. Where isFull(), answer() comes first.
  Reply ask(const Pyramid& pyramid, const LookupKind& kind, LevelMix mix, float s, float t, When when);
  bool isFull() const { return asked_ == kBlock; }
  uint32_t asked() const { return asked_; }
  // What has been asked for since the last answer: four numbers each, of which those beyond the file's channels mean
  // nothing.
  void answer(float (*out)[4]);
  // No more tiles can be noted before these are fetched: they would not be held together.
  bool isCrowded() const { return isCrowded_; }
  // Whether tiles that were lacking have lately taken long to come. Where they lie in the cache's memory it is quicker
  // to take them as they are found out.
  bool isLagging() const { return lag_ > 20.f; }
  // Reads what is wanted: each once, file by file, rows of a level from the top; nothing asked may be unanswered.
  void fetch();
  // Forgets what was wanted, keeps what was fetched as it keeps other tiles; nothing asked may be unanswered.
  void settle();
  // Of the last tile that could not be read; "" when that has been asked.
  std::string reason() { return std::exchange(why_, std::string()); }

 private:
  struct Tile {
    const Pyramid* pyramid = nullptr;
    uint64_t place = 0;  // level, y and x
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
  static constexpr int kSlotBits = 9;
  static constexpr uint32_t kSlots = 1u << kSlotBits;
  static_assert(kSlots >= 2 * kMostWanted);
  static uint64_t placeOf(int level, int tileX, int tileY) {
    return uint64_t(level) << 56 | uint64_t(tileY) << 28 | uint64_t(tileX);
  }
  static int levelOf(uint64_t place) { return int(place >> 56); }
  static int tileYOf(uint64_t place) { return int(place >> 28 & 0xfffffffu); }
  static int tileXOf(uint64_t place) { return int(place & 0xfffffffu); }
  void read(TileRead* reads, uint32_t count);
  static TileRead readOf(const Pyramid& p, uint64_t place);
  static uint32_t hashOf(const Pyramid& p, int level, int tileX, int tileY) {
    const uint32_t name = uint32_t(reinterpret_cast<uintptr_t>(&p) >> 5) * 0x9E3779B1u;
    return (name >> 16) + uint32_t(tileX) + uint32_t(tileY) * 7u + uint32_t(level) * 29u;
  }
  // Of one that the cache has handed out; false where its texels are of a type that lookups don't know.
  bool describe(Tile& tile, const Pyramid& p, uint64_t place, OIIO::ImageCache::Tile* handle);
  const Tile* fetchedAt(const Pyramid& p, uint64_t place) const;
  void want(const Pyramid& p, uint64_t place);
  const Tile* find(const Pyramid& p, int level, int tileX, int tileY);
  // find() where it is not held; apart, so that the rest stays small.
  [[gnu::noinline]] const Tile* lacking(const Pyramid& p, uint64_t place, Tile& oldest);
  void endBlock();
  void giveBack(Tile& tile);
  void makeRoom(uint64_t left);
  Tile& put(const Tile& tile, Tile& place);
  static void markBroken(const Pyramid& p);
  // Texels of kSide columns and rows from (x, y) on. False where a tile cannot be read.
  template <int kSide>
  bool texels(const Pyramid& p, const LookupKind& kind, int level, int x, int y, const char** out, int& type);
  bool tap(const Pyramid& p, const LookupKind& kind, int level, float s, float t, Tap& tap);
  bool cubicTap(const Pyramid& p, const LookupKind& kind, float s, float t, CubicTap& tap);
  static uint32_t offsetOf(const Tile& tile, uint32_t at, const LookupKind& kind);
  const char* texelAt(const Tile& tile, uint32_t offset);

  OIIO::ImageCache& cache_;
  TileReaders& readers_;
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

  When when_ = When::Now;    // of the lookup that is being asked
  bool isAwaiting_ = false;  // a tile of it
  std::string why_;
  float lag_ = 1000;  // microseconds for each tile that was lacking, averaged over the last ones
  // Tiles that lookups wait for, then those that were read for them, in order of file and place. Fetched ones without a
  // handle cannot be read.
  struct Wanted {
    const Pyramid* pyramid;
    uint64_t place;
  };
  Wanted wanted_[kMostWanted];
  uint16_t slots_[kSlots] = {};  // hashed; 1 + the index of what is wanted, 0: none
  uint32_t wantedCount_ = 0, fetchedCount_ = 0;
  uint64_t wantedBytes_ = 0;
  bool isCrowded_ = false;
  TileRead reads_[kMostWanted];
  Tile fetched_[kMostWanted];
};

}  // namespace kinora::texture
