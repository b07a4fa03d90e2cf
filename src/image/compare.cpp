#include "image/compare.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace kinora::image {
namespace {

struct Pair {
  int a, b;
};

Status match(const Image& a, const Image& b, const std::vector<std::string>& wanted, std::vector<Pair>& pairs) {
  if (a.width() != b.width() || a.height() != b.height())
    return Status::fail("IMAGE-COMPARE", "the pictures have different sizes: " + std::to_string(a.width()) + " x " +
                                             std::to_string(a.height()) + " and " + std::to_string(b.width()) +
                                             " x " + std::to_string(b.height()));
  for (const std::string& name : wanted)
    if (a.findChannel(name) < 0 || b.findChannel(name) < 0)
      return Status::fail("IMAGE-COMPARE", "channel \"" + name + "\" is not in both pictures");
  for (int c = 0; c < a.channelCount(); ++c) {
    const std::string& name = a.channels[size_t(c)].name;
    if (!wanted.empty() && std::find(wanted.begin(), wanted.end(), name) == wanted.end()) continue;
    if (const int other = b.findChannel(name); other >= 0) pairs.push_back({c, other});
  }
  if (pairs.empty()) return Status::fail("IMAGE-COMPARE", "the pictures have no channel in common");
  return {};
}

}  // namespace

Status compare(const Image& a, const Image& b, const CompareOptions& options, Difference& out) {
  out = {};
  std::vector<Pair> pairs;
  if (Status s = match(a, b, options.channels, pairs); !s.ok()) return s;
  for (const ChannelInfo& c : a.channels)
    if (b.findChannel(c.name) < 0) out.onlyA.push_back(c.name);
  for (const ChannelInfo& c : b.channels)
    if (a.findChannel(c.name) < 0) out.onlyB.push_back(c.name);

  double squared = 0, relative = 0, sumA = 0, sumB = 0;
  uint64_t finite = 0;
  bool isBitEqual = true;
  const auto end = [](float share, int side) { return int(std::ceil(share * float(side))); };
  const Window part{end(options.part[0], a.width()), end(options.part[2], a.height()),
                    end(options.part[1], a.width()), end(options.part[3], a.height())};
  out.pixels = part.pixels();
  out.values = out.pixels * pairs.size();
  for (uint64_t i = 0; i < a.data.pixels(); ++i) {
    if (!part.contains(int(i % uint64_t(a.width())), int(i / uint64_t(a.width())))) continue;
    bool pixelDiffers = false;
    for (const Pair& p : pairs) {
      const float va = a.pixels[size_t(i) * a.channels.size() + size_t(p.a)];
      const float vb = b.pixels[size_t(i) * b.channels.size() + size_t(p.b)];
      isBitEqual &= std::bit_cast<uint32_t>(va) == std::bit_cast<uint32_t>(vb);
      const bool isNanA = std::isnan(va), isNanB = std::isnan(vb);
      out.nanA += isNanA;
      out.nanB += isNanB;
      if (isNanA || isNanB) {
        out.oneSidedNan += isNanA != isNanB;
        out.differingValues += isNanA != isNanB;
        pixelDiffers |= isNanA != isNanB;
        continue;
      }
      const double d = va == vb ? 0.0 : std::fabs(double(va) - double(vb));  // equal infinities do not differ
      if (d > options.valueThreshold) {
        ++out.differingValues;
        pixelDiffers = true;
      }
      if (d > out.maximum) {
        out.maximum = d;
        out.maximumX = a.data.x0 + int(i % uint64_t(a.width()));
        out.maximumY = a.data.y0 + int(i / uint64_t(a.width()));
        out.maximumChannel = a.channels[size_t(p.a)].name;
      }
      if (!std::isfinite(va) || !std::isfinite(vb)) continue;
      ++finite;
      sumA += va;
      sumB += vb;
      squared += d * d;
      relative += d * d / (double(vb) * vb + options.relativeEpsilon);
    }
    out.differingPixels += pixelDiffers;
  }
  if (finite) {
    out.rmse = std::sqrt(squared / double(finite));
    out.relativeMse = relative / double(finite);
    out.meanA = sumA / double(finite);
    out.meanB = sumB / double(finite);
  }
  out.isBitEqual = isBitEqual && out.onlyA.empty() && out.onlyB.empty() && a.data == b.data && a.display == b.display;
  return {};
}

Status differencePicture(const Image& a, const Image& b, float gain, Image& out) {
  std::vector<Pair> pairs;
  if (Status s = match(a, b, {}, pairs); !s.ok()) return s;
  std::vector<ChannelInfo> channels;
  for (const Pair& p : pairs) channels.push_back(a.channels[size_t(p.a)]);
  out = Image(a.data, channels);
  out.display = a.display;
  for (size_t i = 0; i < size_t(a.data.pixels()); ++i)
    for (size_t c = 0; c < pairs.size(); ++c) {
      const float va = a.pixels[i * a.channels.size() + size_t(pairs[c].a)];
      const float vb = b.pixels[i * b.channels.size() + size_t(pairs[c].b)];
      const bool isNanA = std::isnan(va), isNanB = std::isnan(vb);
      out.pixels[i * pairs.size() + c] = isNanA || isNanB ? (isNanA != isNanB ? gain : 0.0f)
                                         : va == vb       ? 0.0f
                                                          : std::fabs(va - vb) * gain;
    }
  return {};
}

}  // namespace kinora::image
