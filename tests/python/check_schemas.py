"""Checks the published schemas with other programs: JSON Schema with `jsonschema`, USD schemas with `usd-core`.

    python3 -m venv venv && venv/bin/pip install jsonschema usd-core
    venv/bin/python tests/python/check_schemas.py
"""
import glob
import json
import os
import tomllib

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "")
os.environ["PXR_PLUGINPATH_NAME"] = os.path.join(ROOT, "schemas", "usd", "eyebox")

from jsonschema import Draft202012Validator as V
from pxr import Usd, UsdGeom
from referencing import Registry, Resource

R = ROOT
sc=json.load(open(R+'schemas/sidecar.schema.json')); V.check_schema(sc)
def errs(v,x): return [f"{list(e.absolute_path)}: {e.message[:100]}" for e in v.iter_errors(x)]
v=V(sc); n=0
for f in glob.glob(R+'samples/**/*.optics.toml',recursive=True):
    e=errs(v,tomllib.load(open(f,'rb'))); n+=1; assert not e, (f, e)
good='schema=1\nasset="a.glb"\n'
for t in ['[[bind]]\npath="x"\nfinnish="polished"','[[bind]]\npath="x"\nior=0.5','[[bind]]\nglass="PMMA"','[[bind]]\npath="x"\nfaces=[0]\nnormal="+z"\nfinish="polished"','[[bind]]\npath="x"\nfinish={kind="gauss",sigma=6}','[[bind]]\npath="x"\nshape="sphere2"','[eye]\npupil_diameter=4','wavelengths={mono_nm=100}','[coating.ar]\nstack=[]']:
    assert errs(v,tomllib.loads(good+t)),t
for t in ['[[bind]]\npath="x"\nfinish={gauss={sigma_deg=6}}','[[bind]]\npath="x"\nslide={contrast="inf"}','wavelengths="visible"','[[bind]]\npath="x"\nabsorption_per_m=[[500,1],[600,2]]\nemitter={spectrum={cct=5000}}']:
    assert not errs(v,tomllib.loads(good+t)),(t,errs(v,tomllib.loads(good+t)))
stub={"$schema":"https://json-schema.org/draft/2020-12/schema","$id":"glTFProperty.schema.json","type":"object","properties":{"extensions":{"type":"object"},"extras":{}}}
res=[("glTFProperty.schema.json",Resource.from_contents(stub))]
S={}
for f in glob.glob(R+'schemas/gltf/EYEBOX_optics/schema/*.json'):
    j=json.load(open(f)); V.check_schema(j); S[j['$id']]=j; res.append((j['$id'],Resource.from_contents(j)))
reg=Registry().with_resources(res)
ex=open(R+'schemas/gltf/EYEBOX_optics/README.md').read().split('```json')[1].split('```')[0]
ex=json.loads(ex)
g=V(S['glTF.EYEBOX_optics.schema.json'],registry=reg); nd=V(S['node.EYEBOX_optics.schema.json'],registry=reg); pr=V(S['mesh.primitive.EYEBOX_optics.schema.json'],registry=reg); mt=V(S['material.EYEBOX_optics.schema.json'],registry=reg)
assert not errs(g,ex['extensions']['EYEBOX_optics'])
assert not any(errs(nd,x['extensions']['EYEBOX_optics']) for x in ex['nodes'])
assert errs(g,{}) and errs(nd,{"ior":0.5}) and errs(nd,{"faces":[{"finish":"none"}]}) and errs(pr,{"emitter":{"flux_lm":-1}}), "bad accepted"
assert not errs(pr,{"shape":{"kind":"sphere","vertex":[0,0,0],"axis":[0,0,1],"radius":50},"extras":1}); assert not errs(mt,{"finish":"polished","coating":0})
assert n > 0
print(n, 'sidecars and the example of the extension fit their schemas')

reg=Usd.SchemaRegistry()
names=[f"Eyebox{n}API_1" for n in "Asset Medium Finish Coating Shape Emitter Slide Sky Sun Eye".split()]
st=Usd.Stage.CreateInMemory()
p=UsdGeom.Mesh.Define(st,'/M').GetPrim()
n=0
for name in names:
    d=reg.FindAppliedAPIPrimDefinition(name); assert d, name
    t=Usd.SchemaRegistry.GetTypeFromSchemaTypeName(name); assert not t.isUnknown, name
    assert p.CanApplyAPI(t), name
    p.ApplyAPI(t); assert p.HasAPI(t), name
    for q in d.GetPropertyNames():
        a=p.GetAttribute(q); assert a and a.GetDocumentation(), (name,q); n+=1
        sp=d.GetSchemaAttributeSpec(q) if hasattr(d,'GetSchemaAttributeSpec') else None
        assert a.GetTypeName()==sp.typeName, q
        assert not a.HasAuthoredValue() and a.Get() is None, q
t=Usd.SchemaRegistry.GetTypeFromSchemaTypeName('EyeboxFaceAPI_1'); assert not t.isUnknown
assert p.CanApplyAPI(t,'top'); p.ApplyAPI(t,'top'); assert p.HasAPI(t,'top')
for q,ty in [('eyebox:face:top:faces','int[]'),('eyebox:face:top:normal','token'),('eyebox:face:top:emitter:flux_lm','double'),('eyebox:face:top:coating:stack:n','double[]'),('eyebox:face:top:slide:image','asset')]:
    a=p.GetAttribute(q); assert a and str(a.GetTypeName())==ty,(q,a.GetTypeName())
print(n, 'properties of single-apply schemas in usd-core', Usd.GetVersion())
