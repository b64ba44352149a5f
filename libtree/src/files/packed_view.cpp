// SPDX-License-Identifier: MIT
#include "files/packed_view.hpp"

#include <meshoptimizer.h>

#include "files/gltf_document.hpp"

namespace silvafit::tree {
namespace {

constexpr std::size_t kLargestPackedStride = 256;
/// Compressed attributes have at least two bits for each 16 elements of a byte; compressed
/// triangles and indices have at least one byte each.
constexpr std::size_t kMostExpansion = 64;

void check_stride(const PackedView& view) {
  if (view.mode == "ATTRIBUTES") {
    if (view.stride == 0 || view.stride > kLargestPackedStride || view.stride % 4 != 0) {
      refuse_gltf("compressed attributes have a stride that is not a multiple of 4 up to 256");
    }
  } else if (view.mode == "TRIANGLES" || view.mode == "INDICES") {
    if ((view.stride != 2 && view.stride != 4) ||
        (view.mode == "TRIANGLES" && view.count % 3 != 0)) {
      refuse_gltf("compressed indices have an invalid size");
    }
  } else {
    refuse_gltf("a compressed view has the unknown mode " + view.mode);
  }
}

void unfilter(const PackedView& view, std::string& bytes) {
  const auto& [mode, filter, count, stride] = view;
  if (filter.empty() || filter == "NONE") return;
  if (filter == "OCTAHEDRAL" && (stride == 4 || stride == 8)) {
    meshopt_decodeFilterOct(bytes.data(), count, stride);
  } else if (filter == "QUATERNION" && stride == 8) {
    meshopt_decodeFilterQuat(bytes.data(), count, stride);
  } else if (filter == "EXPONENTIAL" && stride % 4 == 0) {
    meshopt_decodeFilterExp(bytes.data(), count, stride);
  } else {
    refuse_gltf("a compressed view has the unknown filter " + filter);
  }
}

}  // namespace

std::size_t unpacked_size(const PackedView& view, std::string_view source) {
  check_stride(view);
  if (view.count > kMostExpansion * source.size() / view.stride) {
    refuse_gltf("a compressed view declares more elements than its bytes can contain");
  }
  return view.count * view.stride;
}

std::string unpacked(const PackedView& view, std::string_view source) {
  std::string bytes(unpacked_size(view, source), '\0');
  const auto* from = reinterpret_cast<const unsigned char*>(source.data());
  auto* const to = static_cast<void*>(bytes.data());
  const int failed =
      view.mode == "ATTRIBUTES"
          ? meshopt_decodeVertexBuffer(to, view.count, view.stride, from, source.size())
      : view.mode == "TRIANGLES"
          ? meshopt_decodeIndexBuffer(to, view.count, view.stride, from, source.size())
          : meshopt_decodeIndexSequence(to, view.count, view.stride, from, source.size());
  if (failed != 0) refuse_gltf("a compressed view is damaged");
  unfilter(view, bytes);
  return bytes;
}

}  // namespace silvafit::tree
