// Filtered texture lookups for a group of points, over OpenImageIO's texture system and tile cache (one bounded cache
// for all files of a world). Called by shade/ for patterns (Context::texture) and by render/ for light maps
// (Host::image). It deliberately knows no scene: files come as names, problems go to Diagnostics once for each file,
// and nothing throws. A lookup's value depends on (file, s, t, footprint, options) alone: never on threads, on the cache
// or on other points.
#pragma once
#include <kinora/context.h>

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/diagnostics.h"

namespace kinora {

class FileContents;

// Who asks for a file: named in messages.
struct TextureRequest {
  SourcePos pos;
  std::string object;  // "pattern 'wood'"
};

// How tiles that lookups lack are read; for tests and benchmarks. No value depends on it.
struct TextureReading {
  enum Way {
    Measured,  // gathered for a group where they take long to come; by several threads where reads wait for files
    OneByOne,  // by each lookup as it comes
    InOrder,   // gathered, by the thread that looks up
    Together,  // gathered, always by several threads
  };
  Way way = Measured;
  uint32_t delay = 0;  // microseconds that each read takes longer: a disk or a network that is far
};

struct TextureStatistics {
  uint64_t files = 0;  // opened for lookups
  uint64_t lookups = 0;
  uint64_t missingLookups = 0;  // answered with the missing colour
  uint64_t tilesRead = 0;
  uint64_t cacheMisses = 0;  // tile requests that were not in the cache
  uint64_t tilesAgain = 0;   // of these, read before and dropped since
  uint64_t bytesRead = 0;    // uncompressed
  struct File {
    std::string path;
    uint64_t bytesRead = 0, tilesAgain = 0;
  };
  std::vector<File> largest;  // of which most was read, five at most
  uint64_t cacheBytes = 0;    // now
  uint64_t imageBytes = 0;    // whole images held for lights
};

// Thread-safe throughout. Handles stay valid for the life of the system.
class TextureSystem {
 public:
  // What an empty or unusable file name gives: lookups answer with the missing colour.
  static constexpr int kNoTexture = -1;

  // contents: what the files hold is noted there; it outlives the system.
  explicit TextureSystem(Diagnostics& diagnostics, FileContents* contents = nullptr);
  ~TextureSystem();
  TextureSystem(const TextureSystem&) = delete;
  TextureSystem& operator=(const TextureSystem&) = delete;

  // Directories for relative names, in order; the working directory comes last. Set before the first handle is asked
  // for.
  void setSearchPath(std::vector<std::string> directories);
  // The least is one tile of a large file for each thread; smaller limits only cost time.
  void setCacheLimit(uint64_t bytes);
  // Where files without mip levels are kept with them, made when they are first looked up; later frames and other
  // processes find them there. It changes no value, and may be emptied between frames. "": nowhere. Set before the
  // first handle is asked for.
  void setLevelFolder(std::string folder);

  void setReading(TextureReading reading);

  // A name along the search path; names from other machines are sought by ever shorter tails ("/a/b/c.tex":
  // "b/c.tex", "c.tex"), then with other extensions (.tex, .tx, .exr, .tif, .png, ...). The tokens <UDIM>, <U>_<V>,
  // <u>_<v> and _MAPID_ name an atlas: one file for each unit square of (s, 1 - t).
  int handle(const std::string& file, const TextureRequest& request);

  // n lookups. handles: one for all points, or n of them when `varying`. s, t (down) and radius in texture space,
  // where the image is the unit square; a footprint of radius r filters about 2r. axes: null, or by point s and t of two
  // conjugate half diameters of an elliptical footprint, which then counts in place of the radius unless all four are 0 or
  // some are no numbers: up to 8 probes along the middle half of its longer axis at the level of the shorter one, but for filter 0
  // (nearest). Writes colour and alpha: files of one channel are grey, files without alpha have alpha 1.
  void lookup(const int32_t* handles, bool varying, uint32_t n, const float* s, const float* t, const float* radius,
              const TextureOptions& options, float* const rgba[4], const float* const* axes = nullptr);

  // lookup() of another part of the files: by number, or by name where there is one. mirror: wrap modes 4 of the
  // options.
  struct Part {
    int number = 0;
    std::string_view name;
  };
  void lookup(const int32_t* handles, bool varying, uint32_t n, const float* s, const float* t, const float* radius,
              const TextureOptions& options, const Part& part, float* const rgba[4],
              const float* const* axes = nullptr);
  // Channels of a file, of an atlas its first one's; 0: there is none.
  int channels(int handle) const;
  // The file that a name stands for, at a place of an atlas; "" without a message when there is none.
  std::string find(const std::string& file, float s = 0, float t = 0);
  // A fact of a file by its name (OpenImageIO's: "resolution", "channels", "averagecolor", any metadata) as `count`
  // ints, floats or one string. False: there is no such fact, or not of this type.
  bool fact(const std::string& path, const std::string& name, int count, int* ints, float* floats, std::string* text);

  // A whole image as floats, top row first, kept for the life of the system. linearize: 1 decodes sRGB, 0 takes
  // values as they are, -1 decodes when the file says that it is sRGB or stores 8-bit integers. Null after a message.
  const HostImage* image(const std::string& file, int linearize, const TextureRequest& request);

  TextureStatistics statistics() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinora
