// SPDX-License-Identifier: MIT
// Smaller GLB files of any program, for pages.
#pragma once

#include <string>
#include <string_view>

namespace silvafit::tree {

/// The scene with compressed triangles (EXT_meshopt_compression), or unchanged if that is not
/// smaller.
///
/// Positions move by at most 1/65536 of the extent of their part in each direction, texture
/// coordinates by 1/8192, normals by about one degree and tangents by about three. Triangles and
/// vertices may have another order. Nodes, names, extras, materials, pictures, animations and
/// instances do not change. Parts that are compressed already, points, lines and parts with morph
/// targets are kept, and scenes with extensions that may refer to vertices in other ways. \param
/// glb  a file that read_glb() accepts \throws InputError if an attribute that read_glb() does not
/// read exceeds its buffer
std::string packed_glb(std::string_view glb);

/// The bytes in the format zlib (RFC 1950), which browsers read with
/// DecompressionStream("deflate"). Compressed triangles and names become a third shorter.
std::string deflated(std::string_view bytes);

}  // namespace silvafit::tree
