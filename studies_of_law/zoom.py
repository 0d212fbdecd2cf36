import sys; sys.path.insert(0,'/tmp')
from loop import *
def zoom(w,f,t0,t1,out,k0=()):
    s,F,K,h,c=base("re25-118743",w)
    rows=contacts("re25-118743",f,w,t1+.001,k0)
    cell=2*math.pi/10000; T=1e-6
    sl=slice(round(t0/T),round(t1/T),2); x=rows[sl,C.X]/cell; Fk=-rows[sl,C.TORQUE]/K/cell; t=rows[sl,C.T]
    fig,ax=plt.subplots(3,1,figsize=(16,14),sharex=True)
    ax[0].plot(t,x,label="x"); ax[0].plot(t,Fk,label="F/K"); ax[0].plot(t,(rows[sl,C.X_HAND]-rows[sl,C.X])*h/K/cell,label="hand"); ax[0].legend(); ax[0].grid()
    ax[1].plot(t,rows[sl,C.FLUX],label="chi"); ax[1].grid(); ax[1].legend()
    ax[2].plot(t,rows[sl,C.CORRECTION],label="c"); ax[2].plot(t,rows[sl,C.OMEGA]*.1,label="om/10");ax[2].grid(); ax[2].legend()
    plt.tight_layout(); plt.savefig(out,dpi=55)
zoom(sys.argv[1],float(sys.argv[2]),float(sys.argv[3]),float(sys.argv[4]),sys.argv[5])
