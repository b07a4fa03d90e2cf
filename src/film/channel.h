// The channels of a film: what is summed for each pixel, how, and where its floats lie in a sample record. Built once
// for each frame by display_output.h from the scene's displays (or by hand in tests), read by Film and by the loop
// that fills records. It does not know where values come from: `source` is a name that the integrator answers to.
#pragma once
#include <array>
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

// What of the samples is written: their filtered value, their variance, or that of their mean (variance / samples).
enum class Statistic : uint8_t { Value, Variance, MeanVariance };

// A pixel filter of a channel's own, "" for the frame's. Samples lie where the frame's filter puts them: this one is
// weighed in (filter_ratio.h).
struct ChannelFilter {
  std::string name;
  float xWidth = 0, yWidth = 0;
  bool operator==(const ChannelFilter&) const = default;
};

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
  Statistic statistic = Statistic::Value;
  ChannelFilter filter;
  // Firefly remap (a b c, all 0: none): samples above a are compressed before they are summed, c to b, and the sum is
  // expanded again. Part of the record entry's name: see remappedSource().
  std::array<float, 3> remap{0, 0, 0};
  bool isRemapped() const { return remap[2] > 0; }
  double step() const { return std::ldexp(1.0, stepLog2); }
  bool operator==(const Channel&) const = default;
};

// Channels with the usual type, precision and limit for what they hold.
Channel colorChannel(std::string name, std::string source = {});     // step 2^-30, limit 65,536
Channel floatChannel(std::string name, std::string source = {});     // the same, one float; alpha and masks
Channel positionChannel(std::string name, std::string source = {});  // step 2^-16, limit 2^30: P and other points
Channel normalChannel(std::string name, std::string source = {});    // data, step 2^-30
Channel depthChannel(std::string name, std::string source = {});     // Min of one float: z of the first hit

// The compression and its inverse; `a < b < c`. x <= a stays; above, the curve begins with slope 1 and bends so that
// c comes to b.
float compress(float x, const std::array<float, 3>& remap);
float expand(float y, const std::array<float, 3>& remap);
// Name of the record entry that one channel has for itself: what changes it there changes no other channel.
std::string ownSource(const std::string& channel, const std::string& source);
// Name of the record entry that holds a source's values compressed, and back (the source itself when it is none).
std::string remappedSource(const std::string& source, const std::array<float, 3>& remap);
std::string sourceBehind(const std::string& entry, std::array<float, 3>& remap);

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
  // Filters of their own that channels have, each once; at most kMaxFilters.
  static constexpr int kMaxFilters = 8;
  const std::vector<ChannelFilter>& filters() const { return filters_; }
  int filterOf(int channel) const { return filterOf_[size_t(channel)]; }  // index into filters(); -1: the frame's
  // How much of a filter (-1: the frame's) is negative: the mean of what its sample weights lie below 0, where their
  // mean is 1. 0, as it begins, is a filter without negative lobes. Film keeps both lobes' sums apart where it is
  // more.
  void setNegative(int filter, double mean);
  double negative(int filter) const {
    return size_t(filter + 1) < negative_.size() ? negative_[size_t(filter + 1)] : 0.0;
  }
  bool operator==(const ChannelLayout&) const = default;

 private:
  int entryOf(const std::string& source, int width, std::string* error);
  std::vector<Channel> channels_;
  std::vector<int> offsets_, filterOf_;
  std::vector<ChannelFilter> filters_;
  std::vector<double> negative_;  // by filter + 1; those behind the last are 0
  std::vector<RecordEntry> record_;
  int recordFloats_ = 0;
  int depthOffset_ = -1;
};

}  // namespace kinora::film
