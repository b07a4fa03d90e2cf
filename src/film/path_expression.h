// Light path expressions: from text to a tree of sets of events. Read by path_automaton.h, and by
// display_channels.cpp for its messages. Grammar: the regular expressions of OSL over the events of a path, from the
// camera on (C), with RenderMan's lobe numbers: D1-D4, S1-S8, U1-U12. A label in quotes is that of the surface
// ("identifier:lpegroup"), the lobe's own name as the bxdf declares it, or, behind L and O, the light's "lightGroup".
// O is a glowing surface or a light that the camera sees itself; L is light from any other light.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kinora::film {

enum PathTypes : uint8_t { kPathReflect = 1, kPathTransmit = 2, kPathVolume = 4, kPathAnyType = 7 };
// Bits of lobes: D1 is bit 0, S1 bit 4, U1 bit 12.
inline constexpr int kFirstSpecularLobe = 4, kFirstUserLobe = 12, kPathLobes = 24;
inline constexpr uint32_t kDiffuseLobes = 0xf, kSpecularLobes = 0xff0, kUserLobes = 0xfff000;

enum class PathEventKind : uint8_t { Camera, Scatter, Light, Object };

// Events of one kind that a part of an expression takes.
struct PathPattern {
  PathEventKind kind = PathEventKind::Scatter;
  uint8_t types = kPathAnyType;                     // Scatter
  uint32_t lobes = kDiffuseLobes | kSpecularLobes;  // Scatter; user lobes are meant only where they are named
  std::optional<std::string> label;                 // none: any
};
// One event: any of the patterns, or none of them.
struct PathAtom {
  std::vector<PathPattern> patterns;
  bool isNegated = false;
};

struct PathNode {
  enum class Kind : uint8_t { Atom, Sequence, Choice, Repeat } kind = Kind::Sequence;
  int atom = -1;
  std::vector<int> children;
  int least = 0, most = 0;  // Repeat; most -1: without end
  size_t column = 0;        // in the text, from 0
};

// What stands before the expression, each ended by a semicolon.
struct PathFlags {
  bool shadows = false, holdouts = false, unoccluded = false, noThroughput = false, noInfiniteCheck = false,
       noClamp = false, overwrite = false;
};

struct PathExpression {
  PathFlags flags;
  std::vector<PathAtom> atoms;
  std::vector<PathNode> nodes;
  int root = -1;
};

struct PathSyntaxError {
  size_t column = 0;  // from 0
  std::string what;
};

// `text`: all behind "lpe:". Nothing when it is malformed; `error` then says where and why.
std::optional<PathExpression> parsePathExpression(std::string_view text, PathSyntaxError& error);

// Two lines to end a message's advice with: the text, and a caret below the column. Long texts are cut around it.
// Lines begin with the sign by which Diagnostics knows them (0x1e).
std::string caretBelow(std::string_view text, size_t column);

}  // namespace kinora::film
