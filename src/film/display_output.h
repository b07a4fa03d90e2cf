// Writes the pictures of a plan from a film: through display driver plug-ins, or through image/ for formats without
// one. Called by render/ at snapshots and at the end, and by `kinora merge`, while no thread adds to the film. Files
// appear whole or not at all; what cannot be written is a message and `false`, for exit code 6.
#pragma once
#include <functional>
#include <array>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "film/display_plan.h"
#include "film/film.h"
#include "film/filtered_pixels.h"
#include "film/shard.h"
#include "image/image.h"

namespace kinora::film {

// What pictures carry besides pixels.
struct FrameMetadata {
  image::Matrix44 worldToCamera{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  std::optional<image::Matrix44>
      worldToNdc;  // (0, 0) to (1, 1) over the display window, y down; none: no matrix does
  std::array<float, 3> screenWindow{0, 0, 0};  // DisplayInfo::screenWindow
  int frame = 0;
  uint64_t seed = 0;
  std::vector<SampleRange> samples;
  double samplesPerPixel = 0;  // mean, where adaptive
  double renderSeconds = 0;
  std::string kinoraVersion, sceneHash, pixelFilter;
  bool isComplete = true;  // false in snapshots and interrupted renders
  std::map<std::string, image::MetaValue> more;
};

// All of it as a file's keys.
std::map<std::string, image::MetaValue> metadataOf(const FrameMetadata& frame);

// The plan's outputs and the camera's matrices as text for shards (ShardInfo::outputs), and back. What a shard states
// itself (frame, seed, samples ...) is not repeated. On reading, `layout` is the shard's.
std::string outputsToJson(const DisplayPlan& plan, const FrameMetadata& frame);
image::Status outputsFromJson(const std::string& text, const ChannelLayout& layout, DisplayPlan& plan,
                              FrameMetadata& frame);

// Parameters that every display takes, whatever its driver.
std::vector<std::string> commonDisplayParameters();

class DisplayOutput {
 public:
  DisplayOutput(DisplayPlan plan, DriverLookup lookup, Diagnostics& diagnostics);
  const DisplayPlan& plan() const { return plan_; }
  // Could all targets be written? Asked before rendering, so that no hour is lost. Errors are reported.
  bool probe();
  // Writes every picture; tries all of them even when one fails.
  bool write(const Film& film, const FrameMetadata& frame);
  // The same in the middle of a render: what cannot be written now is a warning, and the render goes on.
  void snapshot(const Film& film, const FrameMetadata& frame);
  // What changes pixels before the displays get them: display filters.
  using PixelStage = std::function<FilteredPixels(const Film&)>;
  void setPixelStage(PixelStage stage) { stage_ = std::move(stage); }
  // The film's pixels as display filters leave them; none of its channels where there are no filters.
  FilteredPixels filtered(const Film& film) const { return stage_ ? stage_(film) : FilteredPixels(); }
  // Names of the files written by the last write().
  const std::vector<std::string>& written() const { return written_; }

 private:
  bool applyView(const Output& output, const Descriptor& driver, image::Image& picture);
  // Null: there is none that can be used.
  const Descriptor* driverOf(const Output& output) const;
  bool needsPictureLibrary(const Output& output) const;
  bool writeOne(const Output& output, const Film& film, const FilteredPixels& filtered,
                const std::map<std::string, image::MetaValue>& metadata);
  bool writeByPlugin(const Output& output, const Descriptor& driver, image::Image picture);
  std::string colorSpaceOf(const Output& output, bool isView) const;
  bool writeByImage(const Output& output, image::Image picture);
  bool fail(const Output& output, const std::string& why);
  DisplayPlan plan_;
  DriverLookup lookup_;
  PixelStage stage_;
  Diagnostics& diagnostics_;
  std::vector<std::string> written_;
  std::array<float, 3> screenWindow_{0, 0, 0};  // of the frame being written
  bool isSnapshot_ = false;
  const Output* output_ = nullptr;  // that a driver is writing
  std::set<std::string> said_;      // by drivers
};

// The picture of one output: channels with their names and types, windows, metadata. Also for tests and for viewers.
// `isStraight`: its colours are divided by its alpha.
image::Image pictureOf(const Film& film, const Output& output,
                       const std::map<std::string, image::MetaValue>& metadata,
                       const FilteredPixels* filtered = nullptr, bool isStraight = false);

}  // namespace kinora::film
