#include "tests/fuzz/painted_scene.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "tests/scene_util.h"
#include "topotag/family.h"

namespace topotag::fuzz {
namespace {

using test::operator*;

// A marker and the homography from pixels to its units, row-major.
struct PaintedMarker {
  Family family{3};
  uint64_t bits;  ///< of the vertices
  int shape;      ///< 0: squares, 1: discs, 2: between the two
  double frame;   ///< units
  int black, white;
  Matrix3 to_pixels, to_units;
};

Matrix3 Inverse(const Matrix3& m) {
  Matrix3 inverse;
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 3; ++j) {
      const size_t a = (j + 1) % 3, b = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
      inverse[i][j] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
    }
  }
  // Up to a factor, of which the sign is that of the determinant.
  const double determinant =
      m[0][0] * inverse[0][0] + m[0][1] * inverse[1][0] + m[0][2] * inverse[2][0];
  for (auto& row : inverse) {
    for (double& value : row) value /= determinant;
  }
  return inverse;
}

// From units to pixels. Seen by the camera without its lens: about as large as the picture allows,
// or smaller, to a fraction of a pixel a unit; tilted about any axis.
Matrix3 DescribedMap(Input* input, const Camera& camera, int side) {
  const bool is_small = input->Byte() % 4 == 0;
  const double whole = 0.95 * std::min(camera.width, camera.height) / (side + 2);
  const double scale = whole * (is_small ? input->Real(0.05, 0.5) : input->Real(0.5, 1.05));
  const double roll = input->Real(-M_PI, M_PI), axis = input->Real(-M_PI, M_PI);
  const double tilt = input->Real(0, is_small ? 0.6 : 1.2);
  const double z = camera.fx / std::max(scale, 0.3);  // units
  const double around = is_small ? 0.4 : 0.1;
  const double x = (input->Real(0.5 - around, 0.5 + around) * camera.width - camera.cx) / camera.fx;
  const double y =
      (input->Real(0.5 - around, 0.5 + around) * camera.height - camera.cy) / camera.fy;
  Matrix3 r = test::RotationZ(axis) * test::RotationX(tilt) * test::RotationZ(roll - axis);
  if (input->Byte() % 16 == 0) {  // mirrored
    for (auto& row : r) row[0] = -row[0];
  }
  const Matrix3 plane{
      {{r[0][0], r[0][1], x * z}, {r[1][0], r[1][1], y * z}, {r[2][0], r[2][1], z}}};
  const Matrix3 lens{{{camera.fx, 0, camera.cx}, {0, camera.fy, camera.cy}, {0, 0, 1}}};
  return lens * plane;
}

PaintedMarker DescribedMarker(Input* input, const Camera& camera) {
  PaintedMarker marker;
  const int n = input->Between(0, 11);  // small families stand in more pictures
  marker.family = Family(n < 6 ? 3 + n : 3 + n % 3);
  marker.bits = input->Word();
  marker.shape = input->Between(0, 2);
  marker.frame = input->Between(0, 3) == 0 ? 0 : 1;
  const bool is_faint = input->Byte() % 8 == 0;
  marker.black = input->Between(0, is_faint ? 120 : 60);
  marker.white = 255 - input->Between(0, is_faint ? 120 : 60);
  if (input->Byte() % 8 == 0) std::swap(marker.black, marker.white);
  marker.to_pixels = DescribedMap(input, camera, marker.family.white_side());
  marker.to_units = Inverse(marker.to_pixels);
  return marker;
}

bool IsInside(int shape, double x, double y, double half) {
  x = std::abs(x);
  y = std::abs(y);
  if (shape == 1) return x * x + y * y <= half * half;
  return std::max(x, y) <= half && (shape == 0 || x + y <= 1.6 * half);
}

// Level at a point of the marker's plane, or -1 outside.
int LevelAt(const PaintedMarker& marker, double x, double y) {
  const int n = marker.family.n();
  const double side = 0.5 * marker.family.white_side();
  const double reach = std::max(std::abs(x), std::abs(y));
  if (reach > side + marker.frame) return -1;
  if (reach > side) return marker.black;
  const double first = 2.0 * (n - 1);
  const int column = std::clamp(static_cast<int>(std::lround((x + first) / 4)), 0, n - 1);
  const int row = std::clamp(static_cast<int>(std::lround((y + first) / 4)), 0, n - 1);
  const double dx = x - (4 * column - first);
  const double dy = y - (4 * row - first);
  const int vertex = row * n + column;
  if (row == 0 && column <= 1) {
    // The baseline node: two shapes, 2 units apart, each with a hole.
    const double from_p1 = x + first;
    const bool is_second = from_p1 > 1;
    if (IsInside(marker.shape, from_p1 - (is_second ? 2 : 0), dy, 0.5)) return marker.white;
    const bool is_black =
        IsInside(marker.shape, from_p1, dy, 1.5) || IsInside(marker.shape, from_p1 - 2, dy, 1.5);
    return is_black ? marker.black : marker.white;
  }
  if (!IsInside(marker.shape, dx, dy, 1.5)) return marker.white;
  const bool has_hole = (marker.bits >> vertex & 1) != 0;
  return has_hole && IsInside(marker.shape, dx, dy, 0.5) ? marker.white : marker.black;
}

// The pixels that a marker may cover.
Rect BoxOf(const PaintedMarker& marker, const ImageView& view) {
  const double reach = 0.5 * marker.family.white_side() + marker.frame;
  double x0 = view.width, x1 = 0, y0 = view.height, y1 = 0;
  for (int corner = 0; corner < 4; ++corner) {
    Vector3 p;
    for (size_t i = 0; i < 3; ++i) {
      const auto& row = marker.to_pixels[i];
      p[i] = row[0] * (corner % 2 != 0 ? reach : -reach) +
             row[1] * (corner / 2 != 0 ? reach : -reach) + row[2];
    }
    if (p[2] <= 0) return {0, 0, view.width, view.height};
    x0 = std::min(x0, p[0] / p[2]), x1 = std::max(x1, p[0] / p[2]);
    y0 = std::min(y0, p[1] / p[2]), y1 = std::max(y1, p[1] / p[2]);
  }
  const auto clamped = [](double value, int count) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(count)));
  };
  const int x = clamped(x0 - 1, view.width), y = clamped(y0 - 1, view.height);
  return {x, y, clamped(x1 + 2, view.width) - x, clamped(y1 + 2, view.height) - y};
}

void PaintMarker(const PaintedMarker& marker, PaddedImage* image) {
  const Rect box = BoxOf(marker, image->view());
  for (int y = box.y; y < box.y + box.height; ++y) {
    for (int x = box.x; x < box.x + box.width; ++x) {
      int sum = 0;
      for (int sample = 0; sample < 4; ++sample) {
        const Vector3 pixel{x - 0.25 + 0.5 * (sample & 1), y - 0.25 + 0.5 * (sample >> 1), 1};
        Vector3 p;
        for (size_t i = 0; i < 3; ++i) {
          const auto& row = marker.to_units[i];
          p[i] = row[0] * pixel[0] + row[1] * pixel[1] + row[2] * pixel[2];
        }
        const int level = p[2] > 0 ? LevelAt(marker, p[0] / p[2], p[1] / p[2]) : -1;
        sum += level < 0 ? image->row(y)[x] : level;
      }
      image->row(y)[x] = static_cast<uint8_t>(sum / 4);
    }
  }
}

void PaintBackground(Input* input, PaddedImage* image) {
  const int level = input->Byte(), slope_x = input->Between(-20, 20);
  const int slope_y = input->Between(-20, 20), check = input->Between(0, 80);
  const ImageView view = image->view();
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      int value = level + (slope_x * x + slope_y * y) / 16;
      if (check > 60 && (x / (check - 58) + y / (check - 58)) % 2 != 0) value += 60;
      image->row(y)[x] = static_cast<uint8_t>(std::clamp(value, 0, 255));
    }
  }
}

// A strip from any side, or a bar across, of one level or darker by a factor: a cover or a shadow.
void PaintCover(Input* input, PaddedImage* image) {
  const int kind = input->Between(0, 7);
  if (kind == 0 || kind > 3) return;
  const ImageView view = image->view();
  const double angle = input->Real(-M_PI, M_PI), offset = input->Real(-0.1, 0.6);
  const double c = std::cos(angle), s = std::sin(angle);
  const int level = input->Byte();
  const double width = kind == 2 ? input->Real(0, 0.3) : 2;
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      const double across = c * (static_cast<double>(x) / view.width - 0.5) +
                            s * (static_cast<double>(y) / view.height - 0.5) - offset;
      if (across < 0 || across > width) continue;
      uint8_t& pixel = image->row(y)[x];
      pixel = static_cast<uint8_t>(kind == 3 ? pixel * level / 255 : level);
    }
  }
}

void Blur(PaddedImage* image) {
  const ImageView view = image->view();
  std::vector<uint8_t> line;
  const auto smooth = [&line](auto pixel) {
    for (size_t i = 0; i < line.size(); ++i) line[i] = pixel(static_cast<int>(i));
    for (size_t i = 0; i < line.size(); ++i) {
      const int before = line[i == 0 ? 0 : i - 1], after = line[std::min(i + 1, line.size() - 1)];
      pixel(static_cast<int>(i)) = static_cast<uint8_t>((before + 2 * line[i] + after + 2) / 4);
    }
  };
  line.resize(static_cast<size_t>(view.width));
  for (int y = 0; y < view.height; ++y) {
    smooth([&](int x) -> uint8_t& { return image->row(y)[x]; });
  }
  line.resize(static_cast<size_t>(view.height));
  for (int x = 0; x < view.width; ++x) {
    smooth([&](int y) -> uint8_t& { return image->row(y)[x]; });
  }
}

void AddNoise(Input* input, PaddedImage* image) {
  const int kind = input->Between(0, 7);
  const int amplitude = kind < 4 ? 0 : kind < 7 ? kind : input->Between(0, 127);
  if (amplitude == 0) return;
  Random random(input->Byte());
  for (int y = 0; y < image->view().height; ++y) {
    for (int x = 0; x < image->view().width; ++x) {
      uint8_t& pixel = image->row(y)[x];
      const int noisy = pixel + random.Between(-amplitude, amplitude);
      pixel = static_cast<uint8_t>(std::clamp(noisy, 0, 255));
    }
  }
}

}  // namespace

void PaintScene(Input* input, const Camera& camera, PaddedImage* image) {
  const ImageView view = image->view();
  PaintBackground(input, image);
  for (int markers = std::max(input->Between(1, 6) - 3, 1); markers > 0; --markers) {
    PaintMarker(DescribedMarker(input, camera), image);
  }
  PaintCover(input, image);
  for (int passes = input->Between(0, 3); passes > 0; --passes) Blur(image);
  AddNoise(input, image);
  while (input->left() >= 5) {
    const int x = input->Between(0, 65535) % view.width, y = input->Between(0, 65535) % view.height;
    image->row(y)[x] = input->Byte();
  }
}

}  // namespace topotag::fuzz
