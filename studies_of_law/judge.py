"""python judge.py [group ...]: the new law on golden by scenes, one line a case."""
import sys, math, itertools, os
from multiprocessing import Pool
from wavehaptics.parts.motors import PRESETS, BRUSHLESS_PRESETS
from wavehaptics.studies.anchored import cases
from wavehaptics.studies.report.runs import load
from wavehaptics.ladder.run import measure
P4={"0":None,"++++":(1,1,1,1),"----":(-1,-1,-1,-1),"+-+-":(1,-1,1,-1),"-+-+":(-1,1,-1,1)}
def consts(motor):
    if motor in PRESETS: return PRESETS[motor]
    b=BRUSHLESS_PRESETS[motor]
    class C: pass
    c=C(); c.R_ohm,c.L_h,c.k_t,c.J_kgm2=b.R_ohm,b.L_h,math.sqrt(1.5)*b.pole_pairs*b.psi_vs,b.J_kgm2
    return c
def base(motor,wrong,counts=10000,tick=1e6,hb=.163,force_w=.8,load_j=0.,hand_b=None,hk=.044):
    c=consts(motor); i=math.sqrt(force_w/c.R_ohm); F=c.k_t*i; K=c.k_t**2/c.L_h; h=hk*K
    b=hand_b if hand_b is not None else 2*math.sqrt(K*c.J_kgm2)*hb
    brushed=motor in PRESETS
    fs=4*i; w=P4[wrong]
    s=[f"motor.preset={motor}",f"hand.stiffness={h}",f"hand.damping={b}",f"encoder.counts_per_rev={counts}",
       f"adc.full_scale_a={fs}",f"adc.noise_a={fs*4e-4}","adc.offset_a=0","drive.gain_error=0",f"controller.tick_hz={tick}",
       "controller.lambda=1e9",f"controller.r_hat={c.R_ohm}",f"drive.limit_v={max(12,5*i*c.R_ohm):g}"]
    if not brushed: s=[x for x in s if not x.startswith("drive.limit")]+["controller.extra_ticks=2",f"drive.bus_v={max(24,10*i*c.R_ohm):g}"]
    if load_j>1: s.append(f"load.inertia_kgm2={(load_j-1)*c.J_kgm2}")
    if w:
        r,l,k,o=w
        s+= ([*cases.BRUSHES,"brushes.segments=22",f"brushes.ripple={.04*o}"] if brushed else [f"motor.harmonic_5={.03*o}",f"controller.magnet_hat_rad={.3+.0125*o}"])
        s+=[*((cases.LAG,) if brushed else ()),f"controller.r_hat={c.R_ohm*(1+.1*r)}",f"drive.gain_error={.05*r}",f"controller.l_hat={c.L_h*(1+.1*l)}",f"controller.k_t_hat={c.k_t*(1+.1*k)}",f"adc.offset_a={fs*1.6e-3*o}"]
    return s,F,K,h,c
def scene(motor): return "held_wall" if motor in PRESETS else "brushless_hold"
def go(label,motor,settings,F,K,counts):
    cell=2*math.pi/counts
    try:
        m=measure(load(scene(motor) if not any("impact" in x for x in settings) else "bounce",settings),"golden",compare=False)
    except FloatingPointError as e: return f"{label:60s} LOST {e}"
    except Exception as e: return f"{label:60s} ERR {type(e).__name__} {e}"
    o=[f"{label:60s}"]
    if m["contact_energy_ratio"] is not None: o.append(f"E/E0 {m['contact_energy_ratio']:+.3f}")
    if m["hold_ripple_rms"] is not None: o.append(f"ripple {100*m['hold_ripple_rms']/F:.2f}% off {m['hold_offset_rad']/cell:+.2f}ct depth {abs(m['hold_torque']) /K/cell:.1f}ct F/F0 {abs(m['hold_torque'])/F:.2f}")
    if m["hand"]=="impact": o.append(f"rest {m['restitution']}")
    if m["stiffness"] and m["stiffness_predicted"]: o.append(f"K/Kp {m['stiffness']/m['stiffness_predicted']:.2f}")
    if m["free_space_torque_rms"] is not None: o.append(f"free {100*m['free_space_torque_rms']/F:.2f}%")
    if m["anchor_fault_s"] is not None: o.append(f"FAULT {m['anchor_fault_s']:.3f}")
    if m["clipped_fraction"]: o.append(f"clip {m['clipped_fraction']:.1e}")
    if m["saturated_fraction"]: o.append(f"sat {m['saturated_fraction']:.1e}")
    return " ".join(o)
def press(motor,f,wrong,counts=10000,tick=1e6,**k):
    s,F,K,h,c=base(motor,wrong,counts,tick,**k)
    s+=["hand.path=taps",f"hand.amplitude_rad={F/h}",f"hand.frequency_hz={f}",f"scene.duration_s={2/f if f<1 else 3/f}"]
    return go(f"press {motor} {f}Hz {wrong} {counts}ct {tick/1e3:g}kHz {k or ''}",motor,s,F,K,counts)
def hold(motor,wrong,counts=10000,tick=1e6,dur=1.5,more=(),tag="",**k):
    s,F,K,h,c=base(motor,wrong,counts,tick,**k)
    s+=["hand.path=press",f"hand.amplitude_rad={F/h+F/K}",f"scene.duration_s={dur}",*more]
    return go(f"hold {motor} {wrong} {counts}ct {tick/1e3:g}kHz {k or ''}{tag}",motor,s,F,K,counts)
def bounce(motor,w,wrong,counts=10000,tick=1e6,load_j=1.):
    s,F,K,h,c=base(motor,wrong,counts,tick,load_j=load_j)
    J=c.J_kgm2*load_j; way=min(.05,.01*w); ip=w*math.sqrt(J/c.L_h); tc=math.pi*math.sqrt(J*c.L_h)/c.k_t; v=min(127,max(12,2*c.R_ohm*ip))
    s=[x for x in s if not x.startswith(("hand.","adc.full","drive.limit","adc.noise"))]
    s+=["hand.path=impact",f"hand.speed_rad_s={w}",f"hand.amplitude_rad={way}",f"scene.duration_s={1.5*way/w+4*tc}","adc.bits=12",f"adc.full_scale_a={max(4*F/c.k_t,2*ip)}",f"adc.noise_a=1e-3",f"drive.bus_v={v}",f"drive.limit_v={v}"]
    return go(f"bounce {motor} {w} rad/s {wrong} {counts}ct {tick/1e3:g}kHz J*{load_j}",motor,s,F,K,counts)
M=["re25-118743","re30-48v","re40-148877"]; W=list(P4)
def jobs(groups):
    for g in groups:
        if g=="press":
            for m in M:
                for f in (.5,1.5,4):
                    for w in W: yield press,(m,f,w),{}
        if g=="pressct":
            for ct,t in ((2000,1e6),(40000,1e6),(10000,2e6),(10000,5e5),(10000,1e5),(10000,25e3),(2000,25e3)):
                for f in (.5,1.5,4):
                    for w in W[:4]: yield press,("re25-118743",f,w,ct,t),{}
        if g=="hold":
            for m in M:
                for w in W: yield hold,(m,w),{}
            for ct,t in ((2000,1e6),(40000,1e6),(10000,2e6),(10000,5e5),(10000,1e5),(10000,25e3),(2000,25e3)):
                for w in W: yield hold,("re25-118743",w,ct,t),{}
        if g=="load":
            for m in M[:1]:
                for j in (1,10,50):
                    for b in (.1e-3,.5e-3,2e-3):
                        for w in W: yield hold,(m,w),dict(load_j=j,hand_b=b,dur=2.5)
        if g=="load2":
            for m in M[1:]:
                for j in (10,50):
                    for b in (.1e-3,2e-3):
                        for w in W[:3]: yield hold,(m,w),dict(load_j=j,hand_b=b,dur=2.5)
            for ct,t in ((2000,1e6),(40000,1e6),(10000,1e5),(10000,25e3)):
                for j in (10,50):
                    for b in (.1e-3,2e-3):
                        for w in W[:3]: yield hold,(M[0],w,ct,t),dict(load_j=j,hand_b=b,dur=2.5)
        if g=="hot":
            for m in M:
                for T in (-20,125):
                    for w in W: yield hold,(m,w),dict(force_w=3.2,more=[f"thermal.start_c={T}",f"thermal.ambient_c={min(T,100)}","thermal.magnet_per_k=-0.0011"],tag=f" {T}C rated")
        if g=="hotpress":
            for T in (-20,80,125):
                for w in W: yield hp,(T,w),{}
        if g=="bounce":
            for m in M[:2]:
                for w0 in (.3,1,3,10,30):
                    for w in W: yield bounce,(m,w0,w),{}
            for j in (10,50):
                for w0 in (.3,1,3,10):
                    for w in W[:4]: yield bounce,(M[0],w0,w),dict(load_j=j)
        if g=="bounce2":
            for ct,t in ((2000,1e6),(40000,1e6),(10000,2e6),(10000,1e5),(10000,25e3)):
                for w0 in (.3,1,3,10,30):
                    for w in W[:3]: yield bounce,(M[0],w0,w,ct,t),{}
        if g=="bl":
            for m in ("gbm2804-100t","ec45-flat-70w"):
                for w in W: yield hold,(m,w),{}
                for f in (.5,1.5,4):
                    for w in W[:4]: yield press,(m,f,w),{}
                for j in (10,50):
                    for b in (.1e-3,2e-3):
                        for w in W[:2]: yield hold,(m,w),dict(load_j=j,hand_b=b,dur=2.5)
def hp(T,w):
    s,F,K,h,c=base(M[0],w,force_w=3.2)
    s+=["hand.path=taps",f"hand.amplitude_rad={F/h}",f"hand.frequency_hz=1","scene.duration_s=3",f"thermal.start_c={T}",f"thermal.ambient_c={min(T,100)}","thermal.magnet_per_k=-0.0011"]
    return go(f"press 1Hz {w} {T} C rated",M[0],s,F,K,10000)
def call(j): return j[0](*j[1],**j[2])
if __name__=="__main__":
    gs=sys.argv[1:]
    J=list(jobs(gs))
    if J: call(J[0])
    with Pool(2) as p:
        for r in p.imap(call,J): print(r,flush=True)
