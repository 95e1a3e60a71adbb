// What rabbit-ear thinks of a flat crease pattern: FOLD JSON on stdin, its findings as JSON on stdout.
// The third coordinate is ignored, as rabbit-ear ignores it.
//   validate      its report on references, duplicates and isolated vertices; "summary" is "valid" or not
//   kawasaki      vertices at which Kawasaki's condition fails (to 1e-6 rad)
//   maekawa       vertices at which mountains and valleys do not differ by two
//   flat_folded   [x, y] of every vertex of the flat-folded state, facet 0 kept in place
// The last three are null where the file refers to something that is not there.
import { readFileSync } from "node:fs";
import ear from "rabbit-ear";

const file = JSON.parse(readFileSync(0, "utf8"));
const graph = { ...file, vertices_coords: file.vertices_coords.map(point => point.slice(0, 2)) };
const validate = ear.graph.validate(graph);
const result = { validate, kawasaki: null, maekawa: null, flat_folded: null };
if ([validate.vertices, validate.edges, validate.faces].every(part => part.references)) {
	ear.graph.populate(graph);
	result.kawasaki = ear.singleVertex.validateKawasaki(graph);
	result.maekawa = ear.singleVertex.validateMaekawa(graph);
	result.flat_folded = ear.graph.makeVerticesCoordsFlatFolded(graph);
}
process.stdout.write(JSON.stringify(result));
