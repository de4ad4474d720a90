// SPDX-License-Identifier: MIT
// Undistortion of a blob's centroid with the second-order term; the float twin of gpu/lens.cpp.

struct Lens {
  vec2 focal_px;
  vec2 centre_px;
  float k1, k2, p1, p2, k3;
};

// Distorted z = 1 coordinates of an undistorted point, and the Jacobian's entries (xx, xy = yx, yy).
vec2 distort(Lens lens, vec2 u, out vec3 jacobian) {
  float x = u.x, y = u.y;
  float s = x * x + y * y;
  float g = 1.0 + s * (lens.k1 + s * (lens.k2 + s * lens.k3));
  float g1 = lens.k1 + s * (2.0 * lens.k2 + s * 3.0 * lens.k3);
  float cross_term = 2.0 * x * y * g1 + 2.0 * (lens.p1 * x + lens.p2 * y);
  jacobian = vec3(g + 2.0 * x * x * g1 + 2.0 * lens.p1 * y + 6.0 * lens.p2 * x, cross_term,
                  g + 2.0 * y * y * g1 + 6.0 * lens.p1 * y + 2.0 * lens.p2 * x);
  return vec2(x * g + 2.0 * lens.p1 * x * y + lens.p2 * (s + 2.0 * x * x),
              y * g + lens.p1 * (s + 2.0 * y * y) + 2.0 * lens.p2 * x * y);
}

// z = 1 plane from distorted z = 1 coordinates by Newton steps of bounded length. False: the model folds over on the
// way from the centre to the point, or no point maps there.
bool undistort(Lens lens, vec2 distorted, out vec2 u, out vec3 jacobian) {
  u = distorted;
  vec2 miss = vec2(1.0);
  bool unfolded = true;
  int turn = 0;
  do {
    miss = distort(lens, u, jacobian) - distorted;
    float determinant = jacobian.x * jacobian.z - jacobian.y * jacobian.y;
    unfolded = determinant > 1e-3 && jacobian.x + jacobian.z > 0.0;
    vec2 step = vec2(jacobian.z * miss.x - jacobian.y * miss.y, jacobian.x * miss.y - jacobian.y * miss.x) / determinant;
    float longest = 0.2 * (0.1 + length(u));
    float len = length(step);
    step *= len > longest ? longest / len : 1.0;
    u = unfolded ? u - step : 0.8 * u;  // beyond the fold: come back towards the centre
    turn++;
  } while (turn < 30 && dot(miss, miss) > 1e-16);
  miss = distort(lens, u, jacobian) - distorted;
  bool good = dot(miss, miss) < 1e-10;
  // The branch that starts at the centre: no fold on the way.
  for (int part = 1; part <= 8; part++) {
    vec3 j;
    distort(lens, u * (float(part) / 8.0), j);
    good = good && j.x * j.z - j.y * j.y > 0.0 && j.x + j.z > 0.0;
  }
  return good;
}

// Mean of the undistorted pixels of a blob: undistort(mean) + 1/2 tr(H cov), H the second derivative of the
// inverse model, from those of the model itself: tr(H cov) = -J^-1 tr(D'' J^-1 cov J^-T). variance: xx, xy, yy in px^2.
vec2 undistort_blob(Lens lens, vec2 pixel, vec3 variance, out bool invertible) {
  vec2 u;
  vec3 jac;
  invertible = undistort(lens, (pixel - lens.centre_px) / lens.focal_px, u, jac);
  if (!invertible) return u;

  float x = u.x, y = u.y, s = x * x + y * y;
  float g1 = lens.k1 + s * (2.0 * lens.k2 + s * 3.0 * lens.k3);
  float g2 = 2.0 * lens.k2 + 6.0 * lens.k3 * s;
  vec3 dx2 = vec3(6.0 * x * g1 + 4.0 * x * x * x * g2 + 6.0 * lens.p2, 2.0 * y * g1 + 4.0 * x * x * y * g2 + 2.0 * lens.p1,
                  2.0 * x * g1 + 4.0 * x * y * y * g2 + 2.0 * lens.p2);
  vec3 dy2 = vec3(2.0 * y * g1 + 4.0 * x * x * y * g2 + 2.0 * lens.p1, 2.0 * x * g1 + 4.0 * x * y * y * g2 + 2.0 * lens.p2,
                  6.0 * y * g1 + 4.0 * y * y * y * g2 + 6.0 * lens.p1);

  float determinant = jac.x * jac.z - jac.y * jac.y;
  mat2 inverse_jacobian = mat2(jac.z, -jac.y, -jac.y, jac.x) / determinant;
  vec2 f = lens.focal_px;
  mat2 cov = mat2(variance.x / (f.x * f.x), variance.y / (f.x * f.y), variance.y / (f.x * f.y), variance.z / (f.y * f.y));
  mat2 c = inverse_jacobian * cov * inverse_jacobian;  // J is symmetric
  vec2 bend = vec2(dx2.x * c[0][0] + 2.0 * dx2.y * c[0][1] + dx2.z * c[1][1],
                   dy2.x * c[0][0] + 2.0 * dy2.y * c[0][1] + dy2.z * c[1][1]);
  return u - 0.5 * (inverse_jacobian * bend);
}
