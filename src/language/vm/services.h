// What programs ask of the renderer, as functions over a batch of points: no strings, no standard types for a point.
// Strings are interned handles (strings.h). Every member may be null: then nothing is found, nothing is printed.
// `points` is the number of points in the batch, `first` the first one's number within the run. A mask says which
// points ask (-1) and which do not (0); null: all. Cells of the others must be left as they are.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>

namespace kinora::language {

class Dictionary;

// One operand or result of a batch. Component k of point i is cells[k][varies ? i : 0].
struct Span {
  float* const* cells = nullptr;  // floats, or the bits of ints and string handles
  uint32_t components = 0;        // 0: not given
  uint8_t base = 0;               // Base of program.h
  bool varies = false;
  float number(uint32_t k, uint32_t i) const { return cells[k][varies ? i : 0]; }
  int32_t integer(uint32_t k, uint32_t i) const {
    int32_t value;
    __builtin_memcpy(&value, cells[k] + (varies ? i : 0), 4);
    return value;
  }
  void set(uint32_t k, uint32_t i, float value) const { cells[k][varies ? i : 0] = value; }
  void set(uint32_t k, uint32_t i, int32_t value) const { __builtin_memcpy(cells[k] + (varies ? i : 0), &value, 4); }
};

struct Batch {
  uint32_t points = 0, first = 0;
  const int32_t* mask = nullptr;
  bool isLive(uint32_t i) const { return !mask || mask[i]; }
};

// texture, texture3d, environment. Coordinates: s, t or the point or direction, with their derivatives along x and y
// (dx.components == 0: none, which are zeros). Options are "token", value pairs in source order.
struct TextureCall {
  Span file, coordinates, dx, dy, dz;
  const Span* tokens = nullptr;  // strings
  const Span* values = nullptr;  // of each token
  uint32_t options = 0;
  Span result, resultDx, resultDy;  // 1 or 3 components; derivatives are zero unless set
  Span alpha, error;                // outputs asked for by "alpha" and "errormessage"
  Span alphaDx, alphaDy;            // as those of the result
};

// A value that a renderer has for getattribute() and its kin: one of the three, and how many.
struct GivenValue {
  const float* floats = nullptr;
  const int32_t* ints = nullptr;
  const std::string* strings = nullptr;
  size_t count = 0;
};
// Gives it to a point in the type that is asked for; false, and nothing done, where the types do not go together
// (osl-numerics, section 11: int to float-based; float to int, triple, float[2], float[4]; float[3] and triple;
// float[2] to triple, whose z is 0; one number to a matrix, along its diagonal). Floats that no int holds give the
// least int.
bool giveValue(const GivenValue& value, const Span& to, uint32_t point);

enum class TextureKind : uint8_t { Texture, Texture3d, Environment };

enum class MessageKind : uint8_t { Printf, Error, Warning, File };

struct RendererServices {
  void* self = nullptr;
  Dictionary* dictionary = nullptr;  // dict_find and its kin; null: nothing is found
  // Which of the named spaces' matrices to common (row vectors), for each point; false: no such space.
  bool (*spaceToCommon)(void* self, const Batch&, int32_t space, Span matrix) = nullptr;
  bool (*commonToSpace)(void* self, const Batch&, int32_t space, Span matrix) = nullptr;
  // found: one int for each point. An object or index that was not given has no components.
  void (*getAttribute)(void* self, const Batch&, Span object, Span name, Span index, Span destination,
                       Span found) = nullptr;
  void (*texture)(void* self, const Batch&, const TextureCall&) = nullptr;
  void (*texture3d)(void* self, const Batch&, const TextureCall&) = nullptr;
  void (*environment)(void* self, const Batch&, const TextureCall&) = nullptr;
  void (*getTextureInfo)(void* self, const Batch&, Span file, Span coordinates, Span name, Span destination,
                         Span found) = nullptr;
  void (*rayType)(void* self, const Batch&, Span name, Span result) = nullptr;
  void (*backfacing)(void* self, const Batch&, Span result) = nullptr;
  void (*surfaceArea)(void* self, const Batch&, Span result) = nullptr;
  void (*trace)(void* self, const Batch&, Span position, Span direction, const Span* tokens, const Span* values,
                uint32_t options, Span result) = nullptr;
  void (*getMessage)(void* self, const Batch&, Span source, Span name, Span destination, Span found) = nullptr;
  // Messages come when a run ends, in the order of points; those of one point in the order of execution.
  void (*message)(void* self, MessageKind, const char* text, uint32_t length, const char* fileName) = nullptr;
};

}  // namespace kinora::language
