// Which samples passes take (render/frame_samples.h): all of them, once, in passes whose ends follow from indices alone
// unless time or caches say otherwise. What passes do with them is not looked at.
#include "render/frame_samples.h"

#include <gtest/gtest.h>

#include <vector>

namespace kinora::render {
namespace {

constexpr film::Window kWindow{0, 0, 8, 4};

FrameSamples samplesOf(int first, int last, int stride = 1) {
  Diagnostics quiet([](const std::string&, Severity) {});
  SampleCounts counts;
  counts.first = first, counts.last = last, counts.stride = stride;
  FrameSamples samples;
  samples.setCounts(counts);
  samples.begin(kWindow, true, scene::Scene(), quiet);
  return samples;
}

// Ends of all passes, each of them after one second.
std::vector<int> endsOf(FrameSamples samples, PassLimits limits = {}) {
  std::vector<int> ends;
  while (samples.areLeft()) {
    ends.push_back(samples.passEnd(limits));
    samples.passDone(ends.back());
    limits.seconds += 1;
  }
  return ends;
}

TEST(FrameSamples, PassesEndOnTheSameIndicesHoweverAFrameIsSplit) {
  EXPECT_EQ(endsOf(samplesOf(0, 40)), (std::vector<int>{1, 2, 4, 8, 16, 32, 40}));
  EXPECT_EQ(endsOf(samplesOf(4, 20)), (std::vector<int>{8, 16, 20}));
  EXPECT_EQ(endsOf(samplesOf(12, 40)), (std::vector<int>{16, 32, 40}));
  EXPECT_EQ(endsOf(samplesOf(1, 8, 3)), (std::vector<int>{2, 5, 8}));
}

TEST(FrameSamples, WhatIsTakenIsCountedByPixelAndInAll) {
  FrameSamples samples = samplesOf(1, 8, 3);
  EXPECT_TRUE(samples.ranges().empty());
  EXPECT_EQ(samples.end(), 1);
  samples.passDone(samples.passEnd({}));
  samples.passDone(samples.passEnd({}));
  EXPECT_EQ(samples.done(), 2);
  EXPECT_EQ(samples.taken(), 2 * kWindow.pixels());
  EXPECT_EQ(samples.next(), 7);
  EXPECT_EQ(samples.end(), 5);
  const std::vector<film::SampleRange> ranges = samples.ranges();
  ASSERT_EQ(ranges.size(), 2u);
  EXPECT_EQ(ranges[0].begin, 1u);
  EXPECT_EQ(ranges[1].begin, 4u);
  EXPECT_EQ(ranges[1].end, 5u);
}

TEST(FrameSamples, APassThatOutlastsItsTimeIsCut) {
  PassLimits limits;
  limits.longest = 4;  // seconds, at about one a sample
  FrameSamples samples = samplesOf(0, 64);
  for (int k = 0; k < 4; ++k) samples.passDone(samples.passEnd({}));
  ASSERT_EQ(samples.next(), 8);
  limits.seconds = 8;
  EXPECT_EQ(samples.passEnd(limits), 12);
  limits.seconds = 80;  // never less than fills a group of rays
  EXPECT_EQ(samples.passEnd(limits), 12);
  limits.seconds = 0.8;
  EXPECT_EQ(samples.passEnd(limits), 16);
  // what the checkpoint before had says nothing of how long samples take
  Checkpoints::Recovered recovered;
  recovered.samples = 8;
  samples.goOn(recovered);
  limits.seconds = 80;
  EXPECT_EQ(samples.passEnd(limits), 16);
}

TEST(FrameSamples, PassesOfRecordsAreNeitherCutNorMadeLonger) {
  PassLimits limits;
  limits.most = 4;
  limits.isFixed = limits.areCachesCrowded = true;
  limits.longest = 0.001;
  EXPECT_EQ(endsOf(samplesOf(0, 16), limits), (std::vector<int>{1, 2, 4, 8, 12, 16}));
}

TEST(FrameSamples, CrowdedCachesMakePassesLong) {
  PassLimits limits;
  limits.areCachesCrowded = true;
  EXPECT_EQ(endsOf(samplesOf(0, 40), limits), (std::vector<int>{16, 32, 40}));
}

TEST(FrameSamples, ProgressGoesBySamplesThatAreLeft) {
  FrameSamples samples = samplesOf(0, 16);
  for (int k = 0; k < 3; ++k) samples.passDone(samples.passEnd({}));
  ASSERT_EQ(samples.done(), 4);
  const Progress p = samples.progress(2);
  EXPECT_DOUBLE_EQ(p.fraction, 0.25);
  EXPECT_DOUBLE_EQ(p.secondsLeft, 6);
  EXPECT_EQ(p.samplesWanted, 16);
}

}  // namespace
}  // namespace kinora::render
