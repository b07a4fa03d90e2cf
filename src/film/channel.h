// The channels of a film: what is summed for each pixel, how, and where its floats lie in a sample record. Built once
// for each frame by display_output.h from the scene's displays (or by hand in tests), read by Film and by the loop
// that fills records. It does not know where values come from: `source` is a name that the integrator answers to.
#pragma once
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kinora::film {

enum class Reducer : uint8_t {
  Sum,      // average by the pixel filter: sum of value x weight over sum of weights
  Average,  // plain average over the samples, the filter's weight ignored
  Total,    // plain sum over the samples (counts, times)
  Min,      // smallest, component by component
  Max,      // largest, component by component
  ZMin,     // the value of the sample nearest in z; equal z: the lower sample index
  ZMax      // the value of the farthest sample; equal z: the lower sample index
};

// Which samples a channel takes; Even and Odd make half buffers (error estimates, denoising). By sample index.
enum class Half : uint8_t { Both, Even, Odd };

enum class ChannelType : uint8_t { Color, Float, Point, Vector, Normal, Int };

struct Channel {
  std::string name;
  ChannelType type = ChannelType::Color;
  int width = 3;  // floats, 1 to 4
  Reducer reducer = Reducer::Sum;
  Half half = Half::Both;
  // Rounding of one sample: to a multiple of 2^stepLog2, after a clamp to +-limit (counted). A power of two, so that
  // scaling is exact and the one rounding is the only loss. limit / step <= 2^46: 2^17 samples at the limit still
  // fit.
  int stepLog2 = -30;
  float limit = 65536.0f;
  bool isData = false;  // not a colour: stored as float instead of half; negative values are not counted
  bool splats = false;  // light paths may splat into it (costs 8 bytes a float and pixel)
  std::string source;   // record entry that it reads; channels of one source share the entry's floats
  double step() const { return std::ldexp(1.0, stepLog2); }
  bool operator==(const Channel&) const = default;
};

// Channels with the usual type, precision and limit for what they hold.
Channel colorChannel(std::string name, std::string source = {});     // step 2^-30, limit 65,536
Channel floatChannel(std::string name, std::string source = {});     // the same, one float; alpha and masks
Channel positionChannel(std::string name, std::string source = {});  // step 2^-16, limit 2^30: P and other points
Channel normalChannel(std::string name, std::string source = {});    // data, step 2^-30
Channel depthChannel(std::string name, std::string source = {});     // Min of one float: z of the first hit

// An entry of the sample record: `width` floats from `offset` on.
struct RecordEntry {
  std::string source;
  int width = 1;
  int offset = 0;
  bool operator==(const RecordEntry&) const = default;
};

class ChannelLayout {
 public:
  static constexpr int kMaxChannels = 1024;
  // Adds a channel and, for a new source, a record entry. Returns its index, or -1 with the reason in `error` (name
  // taken, width or precision out of range, one source with two widths).
  int add(const Channel& channel, std::string* error = nullptr);
  int find(std::string_view name) const;  // -1: none
  const std::vector<Channel>& channels() const { return channels_; }
  const Channel& operator[](int i) const { return channels_[size_t(i)]; }
  int size() const { return int(channels_.size()); }
  const std::vector<RecordEntry>& record() const { return record_; }
  int recordOffset(int channel) const { return offsets_[size_t(channel)]; }
  int recordFloats() const { return recordFloats_; }
  // Offset of the depth by which ZMin and ZMax choose (source "z"); -1 when no channel needs it and none is there.
  int depthOffset() const { return depthOffset_; }
  bool operator==(const ChannelLayout&) const = default;

 private:
  int entryOf(const std::string& source, int width, std::string* error);
  std::vector<Channel> channels_;
  std::vector<int> offsets_;
  std::vector<RecordEntry> record_;
  int recordFloats_ = 0;
  int depthOffset_ = -1;
};

}  // namespace kinora::film
