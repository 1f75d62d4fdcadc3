// Evaluates the functions along one axis that are not zero at c: their values and derivatives by c.
// Returns the number of the first one.
#if BERNSTEIN
int Evaluate(float c, int degree, int cells, out float value[SUPPORT], out float slope[SUPPORT]) {
  float s = 1.0 - c;
  float lower[SUPPORT];   // of degree - 1
  float power = 1.0, binomial = 1.0;
  for (int i = 0; i < degree; ++i) {
    lower[i] = binomial * power;
    power *= c;
    binomial *= float(degree - 1 - i) / float(i + 1);
  }
  power = 1.0;
  for (int i = degree - 1; i >= 0; --i) {
    lower[i] *= power;
    power *= s;
  }
  for (int i = 0; i <= degree; ++i) {
    float before = i > 0 ? lower[i - 1] : 0.0;
    float after = i < degree ? lower[i] : 0.0;
    value[i] = c * before + s * after;
    slope[i] = float(degree) * (before - after);
  }
  return 0;
}
#else
int Evaluate(float c, int degree, int cells, out float value[SUPPORT], out float slope[SUPPORT]) {
  float scaled = c * float(cells);
  int cell = min(int(scaled), cells - 1);
  float t = scaled - float(cell);
  float s = 1.0 - t;
  float h = float(cells);
  if (degree == 1) {
    value[0] = s, slope[0] = -h;
    value[1] = t, slope[1] = h;
  }
#if SUPPORT > 2
  if (degree == 2) {
    value[0] = 0.5 * s * s, slope[0] = -h * s;
    value[1] = 0.5 + t * s, slope[1] = h * (s - t);
    value[2] = 0.5 * t * t, slope[2] = h * t;
  }
#endif
#if SUPPORT > 3
  if (degree == 3) {
    value[0] = s * s * s / 6.0, slope[0] = -0.5 * h * s * s;
    value[1] = (4.0 + t * t * (3.0 * t - 6.0)) / 6.0, slope[1] = 0.5 * h * t * (3.0 * t - 4.0);
    value[2] = (4.0 + s * s * (3.0 * s - 6.0)) / 6.0, slope[2] = -0.5 * h * s * (3.0 * s - 4.0);
    value[3] = t * t * t / 6.0, slope[3] = 0.5 * h * t * t;
  }
#endif
  return cell;
}
#endif
