// The author's layer of sample and display filters: one struct with a function over W samples (or pixels) makes the
// tables of channel_filter.h. Included per target, after <kinora/simd/foreach_target.h>.
//
//   struct MyFilter {
//     using Data = ...;                                               // of one node
//     template <int W> static void filter(const Data&, const ChannelSpan<W>&);
//   };
//   KINORA_SAMPLE_FILTER(MyFilter, .help = "...", .params = kParams, .setUp = setUp<Data>)        // after
//   KINORA_KERNELS_END
#include <kinora/channel_filter.h>
#ifdef KINORA_KERNEL_FILE
#include <kinora/simd/foreach_target.h>
#endif
#include <kinora/simd/wide.h>

#if defined(KINORA_CHANNEL_FILTER_AUTHOR_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_CHANNEL_FILTER_AUTHOR_H_TARGET
#undef KINORA_CHANNEL_FILTER_AUTHOR_H_TARGET
#else
#define KINORA_CHANNEL_FILTER_AUTHOR_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// W samples or pixels from `at` on.
template <int W>
struct ChannelSpan {
  const ChannelFilterArgs& args;
  uint32_t at;
  KN_INLINE ChannelSpan(const ChannelFilterArgs& a, uint32_t i) : args(a), at(i) {}
  bool has(uint32_t channel) const { return args.channels[channel].components > 0; }
  // One float gives three equal ones.
  KN_INLINE Rgb<W> rgb(uint32_t channel) const {
    const FilterChannel& c = args.channels[channel];
    const bool grey = c.components < 3;
    return {Float<W>::load(c.data[0] + at), Float<W>::load(c.data[grey ? 0 : 1] + at),
            Float<W>::load(c.data[grey ? 0 : 2] + at)};
  }
  // A channel of the pixels (dx, dy) to the right and below, as they were before this filter; beyond the border those
  // of the border. For display filters that see the picture.
  KN_INLINE Rgb<W> before(uint32_t channel, int dx, int dy) const {
    const FilterChannel& c = args.channels[channel];
    const int32_t* w = args.window;
    const auto within = [](Int<W> v, int32_t low, int32_t high) {
      v = select(v < Int<W>(low), Int<W>(low), v);
      return select(v < Int<W>(high), v, Int<W>(high - 1));
    };
    const Int<W> x = within(Int<W>::load(args.x + at) + Int<W>(dx), w[0], w[2]),
                 y = within(Int<W>::load(args.y + at) + Int<W>(dy), w[1], w[3]);
    const Int<W> i = (y - Int<W>(w[1])) * Int<W>(w[2] - w[0]) + (x - Int<W>(w[0]));
    const bool grey = c.components < 3;
    return {gather(c.before[0], i), gather(c.before[grey ? 0 : 1], i), gather(c.before[grey ? 0 : 2], i)};
  }
  // Where the pixels are in the full raster: of their middles.
  KN_INLINE Float<W> x() const { return toFloat(Int<W>::load(args.x + at)) + Float<W>(0.5f); }
  KN_INLINE Float<W> y() const { return toFloat(Int<W>::load(args.y + at)) + Float<W>(0.5f); }
  KN_INLINE Float<W> number(uint32_t channel) const { return Float<W>::load(args.channels[channel].data[0] + at); }
  KN_INLINE void set(uint32_t channel, Rgb<W> v) const {
    const FilterChannel& c = args.channels[channel];
    v.x.store(c.data[0] + at);
    if (c.components < 3) return;
    v.y.store(c.data[1] + at);
    v.z.store(c.data[2] + at);
  }
  KN_INLINE void set(uint32_t channel, Float<W> v) const { v.store(args.channels[channel].data[0] + at); }
};

template <class Filter, class Functions>
struct ChannelFilterRunner {
  template <int W>
  static void filter(const void* data, const ChannelFilterArgs* a) {
    for (uint32_t i = 0; i < a->count; i += W)
      Filter::template filter<W>(*static_cast<const typename Filter::Data*>(data), ChannelSpan<W>(*a, i));
  }
  template <int W>
  static constexpr Functions table() {
    return Functions{&filter<W>};
  }
};
template <class Filter>
using SampleFilterRunner = ChannelFilterRunner<Filter, SampleFilterFunctions>;
template <class Filter>
using DisplayFilterRunner = ChannelFilterRunner<Filter, DisplayFilterFunctions>;

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#endif

#include <kinora/simd/tables.h>

// Ends the file of a plug-in, whose struct has its name.
#undef KINORA_SAMPLE_FILTER
#define KINORA_SAMPLE_FILTER(Name, ...) KINORA_PLUGIN(Name, SampleFilterRunner<Name>, SampleFilterPlugin, __VA_ARGS__)
#undef KINORA_DISPLAY_FILTER
#define KINORA_DISPLAY_FILTER(Name, ...) \
  KINORA_PLUGIN(Name, DisplayFilterRunner<Name>, DisplayFilterPlugin, __VA_ARGS__)
