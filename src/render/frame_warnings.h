// What is said of a frame beside what its parts say: channels that nothing fills, bounds and media that were not as they
// were described, pictures without light. Called by the renderer.
#pragma once
#include "base/diagnostics.h"
#include "film/display_output.h"
#include "film/film.h"
#include "plugin/registry.h"
#include "render/frame.h"
#include "render/frame_plan.h"
#include "render/instance.h"
#include "render/procedurals.h"
#include "render/statistics.h"
#include "render/world_build.h"
#include "scene/scene.h"

namespace kinora::render {

// Sources that are no built-in ones are primvars, what lights mark, or PxrTee nodes', and some object should have them.
void warnOfChannels(const FramePlan& plan, const WorldBuilder& builder, const scene::Scene& scene,
                    Diagnostics& diagnostics);
// Of procedurals that were read: rays that meet only what lies outside of a bound do not find what is there.
void warnOfBounds(const Procedurals& procedurals, WorldBuilder& builder, Diagnostics& diagnostics);
// Samples that were no numbers.
void warnOfSamples(const film::FilmCounters& counters, Diagnostics& diagnostics);
// What the integrator wanted to keep or to learn and could not.
void warnOfRecords(const Frame& frame, const Instance& integrator, Diagnostics& diagnostics);
// Rays and paths below surfaces that had no end.
void warnOfPaths(const Statistics& statistics, Diagnostics& diagnostics);
void warnOfMedia(const Instance& integrator, const WorldBuilder& builder, const Statistics& statistics,
                 Diagnostics& diagnostics);
// A picture without any light is seldom what was meant, and the messages before it do not always say why.
void warnOfBlackness(const film::Film& film, const film::DisplayOutput& output, const scene::Scene& scene,
                     bool hasHoles, Registry& registry, Diagnostics& diagnostics);

}  // namespace kinora::render
