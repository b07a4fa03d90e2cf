#include "film/channel.h"

#include <algorithm>
#include <bit>
#include <cstdio>

namespace kinora::film {
namespace {

Channel make(std::string name, std::string source, ChannelType type, int width) {
  Channel c;
  c.source = source.empty() ? name : std::move(source);
  c.name = std::move(name);
  c.type = type;
  c.width = width;
  return c;
}

}  // namespace

Channel colorChannel(std::string name, std::string source) {
  return make(std::move(name), std::move(source), ChannelType::Color, 3);
}
Channel floatChannel(std::string name, std::string source) {
  return make(std::move(name), std::move(source), ChannelType::Float, 1);
}
Channel positionChannel(std::string name, std::string source) {
  Channel c = make(std::move(name), std::move(source), ChannelType::Point, 3);
  c.stepLog2 = -16;
  c.limit = 1073741824.0f;
  c.isData = true;
  return c;
}
Channel normalChannel(std::string name, std::string source) {
  Channel c = make(std::move(name), std::move(source), ChannelType::Normal, 3);
  c.isData = true;
  return c;
}
Channel depthChannel(std::string name, std::string source) {
  Channel c = make(std::move(name), std::move(source), ChannelType::Float, 1);
  c.stepLog2 = -16;
  c.limit = 1073741824.0f;
  c.isData = true;
  c.reducer = Reducer::Min;
  return c;
}

float compress(float x, const std::array<float, 3>& r) {
  if (!(x > r[0])) return x;
  const float t = x - r[0], q = (r[2] - r[1]) / ((r[1] - r[0]) * (r[2] - r[0]));
  return r[0] + t / (1.0f + t * q);
}

float expand(float y, const std::array<float, 3>& r) {
  if (!(y > r[0])) return y;
  const float s = y - r[0], q = (r[2] - r[1]) / ((r[1] - r[0]) * (r[2] - r[0]));
  // negative lobes of a filter can push a mean beyond what single samples reach
  return r[0] + s / std::max(1.0f - s * q, 1e-6f);
}

namespace {
constexpr const char* kOwnPrefix = "(own ";
constexpr const char* kRemapPrefix = "(remap ";
}  // namespace

std::string remappedSource(const std::string& source, const std::array<float, 3>& r) {
  char text[64];
  std::snprintf(text, sizeof text, "%s%08x %08x %08x) ", kRemapPrefix, std::bit_cast<uint32_t>(r[0]),
                std::bit_cast<uint32_t>(r[1]), std::bit_cast<uint32_t>(r[2]));
  return text + source;
}

std::string ownSource(const std::string& channel, const std::string& source) {
  return kOwnPrefix + std::to_string(channel.size()) + " " + channel + ") " + source;
}

std::string sourceBehind(const std::string& entry, std::array<float, 3>& r) {
  unsigned bits[3];
  int used = 0;
  r = {0, 0, 0};
  size_t length = 0;
  if (std::sscanf(entry.c_str(), "(own %zu %n", &length, &used) == 1 && used > 0 &&
      entry.size() > size_t(used) + length + 2)
    return sourceBehind(entry.substr(size_t(used) + length + 2), r);
  used = 0;
  if (std::sscanf(entry.c_str(), "(remap %8x %8x %8x) %n", &bits[0], &bits[1], &bits[2], &used) != 3 || used == 0)
    return entry;
  for (size_t k = 0; k < 3; ++k) r[k] = std::bit_cast<float>(uint32_t(bits[k]));
  return entry.substr(size_t(used));
}

int ChannelLayout::entryOf(const std::string& source, int width, std::string* error) {
  for (const RecordEntry& e : record_) {
    if (e.source != source) continue;
    if (e.width == width) return e.offset;
    if (error)
      *error = "source \"" + source + "\" is asked for with " + std::to_string(width) + " floats and with " +
               std::to_string(e.width);
    return -1;
  }
  record_.push_back({source, width, recordFloats_});
  recordFloats_ += width;
  if (source == "z") depthOffset_ = record_.back().offset;
  return record_.back().offset;
}

int ChannelLayout::add(const Channel& channel, std::string* error) {
  const auto refuse = [&](std::string why) {
    if (error) *error = "channel \"" + channel.name + "\": " + why;
    return -1;
  };
  if (channel.name.empty()) return refuse("it has no name");
  if (find(channel.name) >= 0) return refuse("the name is taken");
  if (size() >= kMaxChannels) return refuse("more than " + std::to_string(kMaxChannels) + " channels");
  if (channel.width < 1 || channel.width > 4) return refuse("its width is not 1 to 4 floats");
  if (channel.stepLog2 < -60 || channel.stepLog2 > 30) return refuse("its step is not between 2^-60 and 2^30");
  // the rounding in film.cpp is exact below 2^51, and 2^17 samples at the limit must fit 63 bits
  if (!(channel.limit > 0) || !(double(channel.limit) / channel.step() <= 70368744177664.0))
    return refuse("its limit is not between 0 and 2^46 steps");
  Channel c = channel;
  if (c.source.empty()) c.source = c.name;
  if (c.source == "z" && c.width != 1) return refuse("source \"z\" is one float");
  // a miss is infinitely far: an average over it is none ("zfiltered" is the finite variant)
  if (c.source == "z" && (c.reducer == Reducer::Sum || c.reducer == Reducer::Average || c.reducer == Reducer::Total))
    return refuse("source \"z\" cannot be averaged; use \"zfiltered\"");
  const bool isSummed = c.reducer == Reducer::Sum || c.reducer == Reducer::Average;
  if (c.statistic != Statistic::Value && !isSummed) return refuse("statistics are of filtered and averaged values");
  if (c.statistic != Statistic::Value && c.half != Half::Both) return refuse("statistics take all samples");
  int filter = -1;
  if (!c.filter.name.empty() && c.reducer == Reducer::Sum) {
    filter = int(std::find(filters_.begin(), filters_.end(), c.filter) - filters_.begin());
    if (filter >= kMaxFilters) return refuse("more than " + std::to_string(kMaxFilters) + " filters of channels");
  }
  if (c.isRemapped()) {
    if (!isSummed || !(c.remap[0] < c.remap[1] && c.remap[1] < c.remap[2]) || c.source == "z")
      return refuse("remap takes three rising numbers, and a value that is averaged");
    std::array<float, 3> before;
    if (sourceBehind(c.source, before) == c.source) c.source = remappedSource(c.source, c.remap);
  }
  // a refused channel must leave no entry behind
  for (const RecordEntry& e : record_)
    if (e.source == c.source && e.width != c.width)
      return refuse("source \"" + c.source + "\" has " + std::to_string(e.width) + " floats elsewhere");
  const int offset = entryOf(c.source, c.width, error);
  if (c.reducer == Reducer::ZMin || c.reducer == Reducer::ZMax) entryOf("z", 1, error);
  if (filter == int(filters_.size())) filters_.push_back(c.filter);
  channels_.push_back(std::move(c));
  offsets_.push_back(offset);
  filterOf_.push_back(filter);
  return size() - 1;
}

void ChannelLayout::setNegative(int filter, double mean) {
  if (negative(filter) == mean) return;
  negative_.resize(std::max(negative_.size(), size_t(filter + 2)));
  negative_[size_t(filter + 1)] = mean;
}

int ChannelLayout::find(std::string_view name) const {
  for (size_t i = 0; i < channels_.size(); ++i)
    if (channels_[i].name == name) return int(i);
  return -1;
}

}  // namespace kinora::film
