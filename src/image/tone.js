// Tone curves of the page of a render and of the page of `lodestar compare`, as src/image/tone.rs has them.

export const srgb = (x) => (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);

const times = (matrix, [r, g, b]) => matrix.map((row) => row[0] * r + row[1] * g + row[2] * b);
const AGX = [[0.842479062253094, 0.0784335999999992, 0.0792237451477643], [0.0423282422610123, 0.878468636469772, 0.0791661274605434],
  [0.0423756549057051, 0.0784336, 0.879142973793104]];
const AGX_BACK = [[1.19687900512017, -0.0980208811401368, -0.0990297440797205], [-0.0528968517574562, 1.15190312990417, -0.0989611768448433],
  [-0.0529716355144438, -0.0980434501171241, 1.15107367264116]];
const ACES = [[0.59719, 0.35458, 0.04823], [0.076, 0.90834, 0.01566], [0.0284, 0.13383, 0.83777]];
const ACES_BACK = [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]];
const sigmoid = (value) => {
  const share = (Math.min(4.026069, Math.max(-12.47393, Math.log2(value))) + 12.47393) / (4.026069 + 12.47393);
  return [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232].reduce((sum, factor) => sum * share + factor, 0);
};
const hable = (x) => (x * (0.15 * x + 0.05) + 0.004) / (x * (0.15 * x + 0.5) + 0.06) - 0.02 / 0.3;
const hill = (v) => (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.432951) + 0.238081);

/** Curves that treat a color as a whole. */
export const FILM_CURVES = {
  agx: (color) => times(AGX_BACK, times(AGX, color).map(sigmoid)),
  filmic: (color) => color.map((value) => srgb(hable(2 * value) / hable(11.2))),
  aces: (color) => times(ACES_BACK, times(ACES, color).map(hill)).map(srgb),
};
